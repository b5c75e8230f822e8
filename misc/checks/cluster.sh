# shellcheck shell=bash
# evaluate.py, evaluate_cluster.py. Sourced by misc/test.sh.

# lose_a_worker OUT LOG COMMAND...: evaluates with two Dask workers, one of which is ended when there is a first result in OUT.
lose_a_worker() {
  local out="$1" log="$2" code=0 pids=() i results=0 address='' dask=("$PYTHON" -m)
  shift 2
  rm -f "$out.json"
  : >"$log"   # it is looked at before the first program may have begun
  "${dask[@]}" distributed.cli.dask_scheduler --host 127.0.0.1 --port 0 --no-dashboard --scheduler-file "$out.json" >>"$log" 2>&1 &
  pids+=($!)
  for i in 1 2; do   # without a nanny, which would start a new one
    "${dask[@]}" distributed.cli.dask_worker --scheduler-file "$out.json" --name "$i" --nthreads 1 --no-nanny --no-dashboard \
      --local-directory "$out.dask" >>"$log" 2>&1 &
    pids+=($!)
  done
  for ((i = 0; i < 600 && $(occurrences 'Registered to' "$log") < 2; i++)); do sleep 0.1; done
  address="$(sed -nE 's/.*"address": "(tcp:[^"]*)".*/\1/p' "$out.json" | head -n 1)"
  limited "$@" --scheduler="$address" --out="$out" &
  local client=$!
  for ((i = 0; i < 600; i++)); do
    results="$(find "$out/results" -name '*.yml.gz' ! -name 'part-*' 2>/dev/null | wc -l)"
    ((results == 0)) || break
    sleep 0.1
  done
  kill -9 "${pids[2]}"
  wait "$client" || code=$?
  kill "${pids[0]}" "${pids[1]}" 2>/dev/null || true
  wait "${pids[@]}" 2>/dev/null || true
  if ((results == 0 || results > 2)); then   # of four: each of the two workers has one to do
    echo "the worker was not ended in the middle: there were $results results"
    return 1
  fi
  return "$code"
}

# kept DIR COMMAND...: the command leaves the results in DIR as they are.
kept() {
  local before after
  before="$(stat -c '%n %y %s' "$1"/results/*.yml.gz)"
  "${@:2}" || return 1
  after="$(stat -c '%n %y %s' "$1"/results/*.yml.gz)"
  [[ "$before" == "$after" ]] || { echo "before: $before; after: $after"; return 1; }
}

# The first two sequences are those of run_evaluation, the third one can't be evaluated.
run_cluster() {
  local work="$1" evaluate="$BUILD_DIR/bin/example_surgtrack_evaluate" make="$BUILD_DIR/bin/example_surgtrack_make_sequence" i
  local python=(env PYTHONDONTWRITEBYTECODE=1 "$PYTHON") options
  mkdir -p "$work/many/deeper"
  cp -r "$work/stereo" "$work/pair" "$work/many"
  for i in 1 2; do
    sample "make_sequence, number $i" limited "$make" --out="$work/many/deeper/$i" --frames=8 --seed="$i"
  done
  options=(--sequences="$work/many" --stereo --quiet)
  sample "evaluate, a folder of sequences" limited "$evaluate" "${options[@]}" --out="$work/one"
  sample "all of them" grep -q '^| all | full | 40 |' "$work/one/table.md"   # 8 frames of five tools
  sample "evaluate, again" kept "$work/one" limited "$evaluate" "${options[@]}" --out="$work/one"
  sample "evaluate.py, two processes" limited "${python[@]}" "$REPO/samples/evaluate.py" "${options[@]}" --jobs=2 \
    --program="$evaluate" --out="$work/processes"
  sample "the same files" evaluation_same "$work/one" "$work/processes"
  rm "$work"/processes/results/1-*.yml.gz
  rm "$work"/processes/*.csv
  sample "evaluate.py, after an interruption" limited "${python[@]}" "$REPO/samples/evaluate.py" "${options[@]}" \
    --program="$evaluate" --out="$work/processes"
  sample "the same files" evaluation_same "$work/one" "$work/processes"
  sample "evaluate.py, again" kept "$work/processes" limited "${python[@]}" "$REPO/samples/evaluate.py" "${options[@]}" \
    --program="$evaluate" --out="$work/processes"
  echo >>"$work/many/pair/kinematics.csv"
  echo "0" >>"$work/many/pair/kinematics.csv"
  sample "refused: a file has changed, and no result of before is taken" refuses "$work/many/pair/kinematics.csv" "$evaluate" \
    "${options[@]}" --out="$work/one"
  sample "refused: the same in Python" refuses "$work/many/pair/kinematics.csv" "${python[@]}" "$REPO/samples/evaluate.py" \
    "${options[@]}" --program="$evaluate" --out="$work/processes"
  sample "the same files of the others" evaluation_same "$work/one" "$work/processes"
  sample "refused: nothing to merge" refuses "has no result" "$evaluate" --sequences="$work/stereo" --out="$work/never" --merge
  sample "refused: part and merge" refuses "'--part'" "$evaluate" --sequences="$work/stereo" --out="$work/never" --merge --part
  sample "refused: no such method, in Python" refuses "'none'" "${python[@]}" "$REPO/samples/evaluate.py" --sequences="$work/many" \
    --program="$evaluate" --out="$work/never" --methods=none
  sample "refused: no such program" refuses "$work/none" "${python[@]}" "$REPO/samples/evaluate.py" --sequences="$work/many" \
    --program="$work/none" --out="$work/never"
  cat >"$work/fails-once" <<SCRIPT
#!/bin/sh
case "\$*" in *--part*) if mkdir "$work/failed-once" 2>/dev/null; then echo 'evaluate: no memory' >&2; exit 1; fi ;; esac
exec "$evaluate" "\$@"
SCRIPT
  chmod +x "$work/fails-once"
  sample "evaluate.py, a sequence fails once" limited "${python[@]}" "$REPO/samples/evaluate.py" --sequences="$work/many/deeper" \
    --methods=epnp --program="$work/fails-once" --out="$work/once" --quiet
  sample "all are there" grep -q '^| all | epnp | 16 |' "$work/once/table.md"
  sample "it has failed" test -d "$work/failed-once"
  if ! "$PYTHON" -c 'import distributed' 2>/dev/null; then
    echo "skipped: evaluate_cluster.py, which needs dask.distributed"
    return 0
  fi
  local cluster=("${python[@]}" "$REPO/samples/evaluate_cluster.py" "${options[@]}" --program="$evaluate")
  sample "refused: no scheduler" refuses "tcp://127.0.0.1:9" "${cluster[@]}" --scheduler=tcp://127.0.0.1:9 --out="$work/cluster"
  cp "$work/pair/kinematics.csv" "$work/many/pair/kinematics.csv"
  sample "evaluate, all of them once more" limited "$evaluate" "${options[@]}" --out="$work/one"
  sample "evaluate_cluster.py, one of two workers is lost" lose_a_worker "$work/cluster" "$LOGS/dask.log" "${cluster[@]}"
  sample "the same files" evaluation_same "$work/one" "$work/cluster"
}

"""A program as users write it, with types: mypy --strict accepts it with the stubs beside it, and it runs."""

from typing import List, Tuple

import cv2
import numpy as np
from cv2 import surgtrack as st
from numpy.typing import NDArray


def distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(a[:3, 3] - b[:3, 3]))


def track(scene: st.SyntheticScene, frames: int) -> List[Tuple[str, float]]:
    model = scene.model()
    params = st.ToolTracker.Params()
    params.method = st.METHOD_FULL
    params.coastingTime = 1.5
    tracker = st.ToolTracker.create(scene.camera(), params)
    tool: int = tracker.addTool(model, scene.nominal_T_base(0))
    result: List[Tuple[str, float]] = []
    for frame in range(frames):
        time = frame / 25.
        estimates = tracker.update(scene.render(frame), time, [scene.recordedJoints(0, time)])
        estimate = estimates[tool]
        for match in estimate.matches:
            x, y = match.imagePoint
            assert x >= 0 and y >= 0 and match.similarity > 0
        result.append((st.stateName(estimate.state), distance(estimate.camera_T_tool, scene.truePose(0, time))))
    return result


def main() -> None:
    params = st.SyntheticScene.Params()
    params.frames = 25
    params.imageSize = (720, 576)
    scene = st.SyntheticScene.create(None, params)
    states = track(scene, 5)
    assert states[-1][0] == 'tracking' and states[-1][1] < 0.004, states   # the calibration is 6 mm off

    camera = st.CameraModel(scene.camera().cameraMatrix(), np.zeros(5), (720, 576))
    points, jacobian = scene.model().keypointPositions(scene.trueJoints(0, 0.))
    projected = camera.projectPoints(points + np.array([0, 0, 0.5]))
    assert projected.shape[0] == points.shape[0] and jacobian.shape[0] == 3 * points.shape[0]
    try:
        st.Sequence.load('/no/such/folder')
    except cv2.error as error:
        assert 'sequence.yaml' in error.err
    else:
        raise AssertionError('a sequence without files was read')


if __name__ == '__main__':
    main()

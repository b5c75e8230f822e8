// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Poses of something else than the tracker, as a run beside its runs.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_POSE_RUN_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_POSE_RUN_HPP

#include "../runs.hpp"

namespace evaluation {

class PoseRun
{
public:
    PoseRun(const Data& data, const String& name) : data_(data)
    {
        run_.method = name;
        scorer_ = PoseScorer::create(data.sequence->leftCamera(), common::modelsOf(data.tools));
    }
    //! Frames without truth are not counted.
    void add(int tool, int frame, int state, const Matx44d& camera_T_tool)
    {
        Truth truth;
        if (!data_.truth(tool, frame, truth))
            return;
        scorer_->add(tool, state, camera_T_tool, truth.camera_T_tool);
        run_.records.push_back(recordOf(data_, tool, frame, state, camera_T_tool, truth));
    }
    //! A frame of the video is done. @param seconds it took
    void addFrame(double seconds)
    {
        run_.frames++;
        run_.seconds += seconds;
    }
    const Run& finish()
    {
        score(data_, *scorer_, run_);
        return run_;
    }

private:
    const Data& data_;
    Ptr<PoseScorer> scorer_;
    Run run_;
};

} // namespace evaluation

#endif

// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_SYNTHETIC_SYNTHETIC_ARM_HPP
#define OPENCV_SURGTRACK_SRC_LAB_SYNTHETIC_SYNTHETIC_ARM_HPP

#include "opencv2/surgtrack/synthetic.hpp"

namespace cv { namespace surgtrack {

// Independent streams of random numbers from one seed.
enum Stream { STREAM_MOTION = 1, STREAM_HAND_EYE, STREAM_READING, STREAM_WHITE, STREAM_TISSUE, STREAM_SENSOR };

RNG makeRng(int seed, Stream stream, uint64 index);

//! A pendulum of two sines; whole periods in the length of the sequence.
struct Motion
{
    double centre, amplitude;
    int cycles[2];
    double phases[2];
    double at(double phase) const    // phase: 0..1 over the sequence
    {
        return centre + amplitude * (0.65 * std::sin(2 * CV_PI * (cycles[0] * phase + phases[0])) +
                                     0.35 * std::sin(2 * CV_PI * (cycles[1] * phase + phases[1])));
    }
};

/** An arm of the synthetic scene: where it stands, how it moves, and how its robot misreads it. */
class SyntheticArm
{
public:
    enum { COORDINATES = 7 };    // at most: six on the way to the end effector, and the jaw

    //! @param tool index: arm 0 enters from the upper right, 1 from the upper left, 2 from the lower right, 3 from the lower left
    SyntheticArm(const Ptr<ToolModel>& model, const SyntheticScene::Params& params, int tool);

    std::vector<double> trueJoints(double time) const;
    std::vector<double> recordedJoints(double time) const;

    Matx44d camera_T_base, nominal_T_base;
    int coordinates[COORDINATES];    //!< of the model, in this order

private:
    void place(const Vec3d& shaft);
    void makeMotion();
    void makePlay();
    double hangAt(int coordinate, double record) const;
    static void keepInside(Motion& m, double low, double high);
    double insertionFor(double reach, const Vec3d& shaft) const;

    Ptr<ToolModel> model_;
    SyntheticScene::Params params_;
    int tool_, count_;    // count_: of coordinates there are
    Mat_<double> limits_;
    Motion motion_[COORDINATES];
    double bias_[COORDINATES], drift_[COORDINATES], driftPhase_[COORDINATES], gain_[COORDINATES], hang_[COORDINATES], coupling_;
    std::vector<double> hangs_;    // a coordinate of each record
};

}} // namespace cv::surgtrack

#endif

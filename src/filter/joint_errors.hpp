// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILTER_JOINT_ERRORS_HPP
#define OPENCV_SURGTRACK_SRC_FILTER_JOINT_ERRORS_HPP

#include "filter/articulated_states.hpp"

namespace cv { namespace surgtrack {

/* What is wrong with the readings of a wrist that cables move, as a sum over constants to be learnt. Of a coordinate q that may be off:
   an offset; a gain, of its travel since the first reading; play, of the direction it came from, in which it hangs until it has
   travelled through the play the other way; and the coupling to the travel of the coordinate before it. d = Phi theta is added to
   the readings. */
class JointErrors
{
public:
    //! @param wrong whether readings may be wrong at all
    JointErrors(const ToolModel& model, const ArticulatedPoseEKF::Params& params, bool wrong);

    //! Coordinates that are jaws, closed at 0: two links that they move against each other.
    static std::vector<uchar> jaws(const ToolModel& model);

    //! Of theta.
    int size() const { return int(priors_.size()); }
    //! Of d: coordinates that may be off.
    int offsets() const { return int(coordinates_.size()); }
    //! Index in d of a coordinate, or -1.
    int offsetOf(size_t coordinate) const { return offsetOf_[coordinate]; }
    //! Index in the state (omega, v, theta) of a coordinate's offset. They come first.
    int stateOf(size_t coordinate) const { return 6 + offsetOf_[coordinate]; }
    //! Standard deviation before anything is known.
    double prior(int i) const { return priors_[i]; }
    //! What a constant is called, as `wrist_yaw gain`.
    const String& name(int i) const { return names_[i]; }

    //! The direction each coordinate came from, -1..1, after it has moved.
    static void hang(const double* before, const double* now, size_t n, double* directions);
    //! d = Phi theta. @param reference first readings, which travel is counted from @param directions see hang()
    void phi(const double* readings, const double* reference, const double* directions, Matrix& result) const;

private:
    struct Term
    {
        enum Kind { OFFSET, GAIN, PLAY, COUPLING } kind;
        int row, coordinate;   // of d; whose travel or direction counts
    };
    void add(Term::Kind kind, int row, size_t coordinate, double prior, const String& name);

    std::vector<int> coordinates_, offsetOf_;
    std::vector<Term> terms_;
    std::vector<double> priors_;
    std::vector<String> names_;
};

}} // namespace cv::surgtrack

#endif

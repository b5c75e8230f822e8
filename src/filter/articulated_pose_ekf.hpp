// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILTER_ARTICULATED_POSE_EKF_HPP
#define OPENCV_SURGTRACK_SRC_FILTER_ARTICULATED_POSE_EKF_HPP

#include "filter/exact_readings.hpp"
#include "filter/joint_errors.hpp"
#include "filter/reading_history.hpp"

// x      error of the state: (omega [rad], v [m], theta); of what is seen: (omega, v, d [rad or m], delay [s])
// P, Q   covariance of the error, of the process noise
// h, r   a measurement's row dh / dx, and its innovation
// A, b   information of all measurements: sum of h h^T / sigma^2, sum of h r / sigma^2

namespace cv { namespace surgtrack {

// ArticulatedPoseEKF::Belief, to calculate with
struct Estimate
{
    Matx44d correction;
    Vector theta;
    Matrix P;
    Vector shift;                     // from here to what is believed, see ExactReadings
    Matx44d believed_T_correction;    // the same of the correction
    Point3d centre;
    bool placed;
    double nis;
};

//! Standard deviations that are added to P.
void checkGrowth(double rotation, double translation);

// articulated_pose_ekf.cpp: state and process; articulated_measurements.cpp: points and edges.
class ArticulatedPoseEKFImpl CV_FINAL : public ArticulatedPoseEKF
{
public:
    ArticulatedPoseEKFImpl(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const Params& params);

    void reset(const Matx44d& correction) CV_OVERRIDE;
    void predict(const std::vector<double>& joints, double growth, double seconds) CV_OVERRIDE;
    void inflate(double rotation, double translation) CV_OVERRIDE;
    void undo() CV_OVERRIDE;
    void begin() CV_OVERRIDE;
    int addPoints(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<int>& parts,
                  const std::vector<Point2d>& imagePoints, std::vector<uchar>& used, const std::vector<double>& noise,
                  double tolerance) CV_OVERRIDE;
    int addContour(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<ContourPoint>& points,
                   double tolerance) CV_OVERRIDE;
    double surprise(double rotation, double translation) const CV_OVERRIDE;
    bool solve() CV_OVERRIDE;
    void dropReadings() CV_OVERRIDE { history_ = earlier_; }
    State state() const CV_OVERRIDE;
    void setState(const State& state) CV_OVERRIDE;
    ReadingErrors readingErrors() const CV_OVERRIDE;
    void setReadingErrors(const ReadingErrors& errors) CV_OVERRIDE;
    void setHandEye(const Matx44d& nominal_T_base) CV_OVERRIDE;
    void moveCamera(const Matx44d& now_T_before) CV_OVERRIDE;
    const ToolView& view() const CV_OVERRIDE { return view_; }
    Matx44d correction() const CV_OVERRIDE { return correction_; }
    double delay() const CV_OVERRIDE { return params_.delay > 0 ? state_.theta[n_ - 7] + state_.shift[n_ - 1] : 0; }
    const std::vector<double>& offsets() const CV_OVERRIDE { return offsets_; }
    const std::vector<double>& joints() const CV_OVERRIDE { return corrected_; }
    void correctJoints(const std::vector<double>& readings, std::vector<double>& joints) const CV_OVERRIDE;
    Mat covariance() const CV_OVERRIDE;
    double edgeBias(int clipped) const CV_OVERRIDE { return bias_[0] + clipped * bias_[1]; }
    double nis() const CV_OVERRIDE { return state_.nis; }
    Matx22d imageCovariance(const CameraModel& camera, const Matx44d& eye_T_camera, int part) const CV_OVERRIDE;
    Matx66d poseCovariance() const CV_OVERRIDE;

private:
    struct Axis
    {
        int state;           // index of the offset in what is seen, or -1
        double rate;         // of the coordinate, at the image's time
        Point3d direction, origin;   // in the camera frame; direction times the joint's scale
        bool revolute;
    };

    // Whether a constant may be another one after a pause.
    bool changes(int i) const { return i < 6 + errors_->offsets() || i >= 6 + errors_->size(); }
    double prior(int i) const { return i - 6 < errors_->size() ? errors_->prior(i - 6) : params_.delay; }
    void place();
    bool row(const CameraModel& camera, const Matx44d& eye_T_camera, int link, const Point3d& linkPoint, Point2d& imagePoint,
             Rows2& H) const;
    void motion(int link, const Point3d& p, Rows3& D) const;
    void setReadings(const std::vector<double>& readings);
    void predictedNow();
    void sumOffsets(const Vector& theta);
    void see();
    SeenVector seenOf(const Vector& x) const;
    Matx44d motionOf(const Vector& x) const;
    void believe();
    SeenMatrix seen(const Matrix& P) const;
    const SeenMatrix& stateSeen() const;
    void marginalise(SeenMatrix& A, SeenVector& b, double& square) const;
    bool posterior(const Matrix& P, const SeenMatrix& A, const SeenVector& b, Vector& x, Matrix& result) const;
    Eigen::Matrix2d edgeBiases() const;
    Vector ofState(const SeenVector& b) const;
    void apply(const Vector& x);

    Ptr<ToolModel> model_;
    Matx44d nominal_T_base_;
    Params params_;
    std::vector<uchar> isJaw_;        // of a coordinate
    std::vector<int> stateOf_;        // of a coordinate: index in what is seen, or -1
    Ptr<JointErrors> errors_;
    int n_, m_;                       // of the state (omega, v, theta), and of what is seen (omega, v, d)
    std::vector<double> joints_;      // readings of this frame
    std::vector<double> reference_;   // of the first frame, or of what was learnt before; none before
    Vector known_;                    // theta, its covariance and reference before the first frame
    Matrix knownP_;
    std::vector<double> knownReference_;
    std::vector<double> directions_;  // see JointErrors
    Matrix phi_;                      // d = phi theta
    std::vector<double> offsets_;     // of a coordinate, d
    ExactReadings exact_;
    ReadingHistory history_, earlier_;   // earlier_: before the last frame
    std::vector<double> late_, rates_;   // of a coordinate: reading at the image's time less that of the frame, and its change a second
    std::vector<double> corrected_;
    ToolView view_;
    std::vector<std::vector<Axis> > axes_;   // of a link: the joints that move it
    Estimate state_, predicted_;
    Matx44d correction_;              // that is believed

    SeenMatrix A_;
    SeenVector b_;
    // The same of what displaces edges together: all of them, and those beside white.
    Eigen::Matrix<double, 2, 2, Eigen::DontAlign> biasA_;
    Eigen::Matrix<double, 2, 1, Eigen::DontAlign> biasb_, bias_;
    SeenColumns2 biasSeen_;
    double square_;                   // sum of r^2 / sigma^2
    int rows_;
    Vector moved_;                    // x of the state since predict()
    SeenVector seenMoved_;            // of what is seen and believed
    SeenMatrix predictedSeen_;        // covariance
    mutable SeenMatrix stateSeen_;    // the same of the state, where it was asked for since the last place()
    mutable bool isStateSeen_ = false;
};

}} // namespace cv::surgtrack

#endif

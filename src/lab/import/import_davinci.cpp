// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/node_reader.hpp"
#include "lab/import/import_tool.hpp"

// The recordings that belong to the paper, as its authors released them (daVinciToolTrack). Millimetres.

namespace cv { namespace surgtrack {

namespace {

const double UNIT = 1e-3;         // [m]
const double ARM = 0.05;          // [m]; weighs an angle against a distance: 1 mm and 0.02 rad are alike
const double TOLERANCE = 1e-3;    // [m]; poses of one frame disagree by up to 0.17 mm and 5e-3 rad in fast motion

Matx44d readPose(const FileNode& node, const String& filename, const String& key)
{
    const Mat m = matrixOf(node);
    Matx44d T = Matx44d::zeros();
    if (m.size() == Size(4, 4) && m.channels() == 1)
        m.convertTo(T, CV_64F);
    if (!isRigid(T))
        importError(filename, "key " + key + ": expected a rigid 4x4 matrix, translation in millimetres");
    for (int i = 0; i < 3; i++)
        T(i, 3) *= UNIT;
    return nearestRigid(T);
}

struct Recording
{
    std::vector<Matx44d> poses[3];    // J4, J5, end effector: base_T_link of q4, q5, q6 in the axes of this module, by frame
    std::vector<double> jaws;         // [rad]
};

Recording readRecording(const String& filename)
{
    const FileStorage file = openStorage(filename);
    const char* const keys[] = { "J4_poses", "J5_poses", "bHe_poses" };
    // Their links have the origins of ours, and the axes of the da Vinci's own tool frame.
    const Matx44d pose_T_link = rigidTransform(Matx33d(0, 0, -1, -1, 0, 0, 0, 1, 0), Vec3d());
    Recording recording;
    for (int k = 0; k < 3; k++)
    {
        const FileNode list = file[keys[k]];
        if (!list.isSeq() || list.size() == 0)
            importError(filename, String("key ") + keys[k] + ": expected a list of 4x4 matrices");
        for (FileNodeIterator it = list.begin(); it != list.end(); ++it)
            recording.poses[k].push_back(readPose(*it, filename, format("%s[%d]", keys[k], (int)recording.poses[k].size())) * pose_T_link);
    }
    const FileNode jaws = file["jaws"];
    for (FileNodeIterator it = jaws.begin(); jaws.isSeq() && it != jaws.end(); ++it)
        recording.jaws.push_back((*it).isReal() || (*it).isInt() ? (double)*it : DBL_MAX);
    const size_t frames = recording.poses[0].size();
    if (recording.poses[1].size() != frames || recording.poses[2].size() != frames || recording.jaws.size() != frames
        || !checkRange(recording.jaws, true, 0, -10, 10))
        importError(filename, format("keys J5_poses, bHe_poses and jaws: expected %d entries each, as J4_poses has", (int)frames));
    return recording;
}

//! Joints from the poses of three links.
class InverseKinematics
{
public:
    explicit InverseKinematics(const Ptr<ToolModel>& model) : model_(model)
    {
        const std::vector<ToolModel::Link>& links = model->links();
        std::vector<int> moving;
        for (int i = model->endEffectorLink(); i >= 0; i = links[i].parent)
            if (links[i].coordinate >= 0)
                moving.insert(moving.begin(), i);
        const size_t coordinates = model->coordinateNames().size();
        if (moving.size() != 6 || coordinates != 7)
            CV_Error(Error::StsBadArg, format("model: %d joints to the end effector and %d coordinates in all, expected 6 and, with the jaw's, 7",
                                              (int)moving.size(), (int)coordinates));
        jaw = 21;   // 0 + 1 + ... + 6, less those of the joints
        for (size_t i = 0; i < 6; i++)
        {
            coordinates_.push_back(links[moving[i]].coordinate);
            jaw -= coordinates_.back();
        }
        if (jaw < 0 || jaw > 6 || std::count(coordinates_.begin(), coordinates_.end(), jaw))
            CV_Error(Error::StsBadArg, "model: expected a coordinate of its own for each of the six joints to the end effector");
        for (int k = 0; k < 3; k++)
            links_[k] = moving[3 + k];
    }

    //! Improves joints. @return the largest distance that is left between the points of poses and model [m]
    double solve(const Recording& recording, size_t frame, std::vector<double>& joints) const
    {
        Mat_<double> J(27, 6), residual(27, 1), step;
        std::vector<double> jacobian(3 * joints.size());
        for (int iteration = 0; ; iteration++)
        {
            std::vector<Matx44d> base_T_link;
            model_->forwardKinematics(joints, base_T_link);
            for (int k = 0; k < 3; k++)
                for (int p = 0; p < 3; p++)   // origin and a point on two axes
                {
                    const Point3d point(p == 1 ? ARM : 0, p == 2 ? ARM : 0, 0);
                    const Point3d is = transform(base_T_link[links_[k]], point), should = transform(recording.poses[k][frame], point);
                    model_->pointJacobian(base_T_link, links_[k], is, &jacobian[0]);
                    const Point3d difference = should - is;
                    const double d[] = { difference.x, difference.y, difference.z };
                    for (int r = 0; r < 3; r++)
                    {
                        residual(9 * k + 3 * p + r) = d[r];
                        for (int c = 0; c < 6; c++)
                            J(9 * k + 3 * p + r, c) = jacobian[r * joints.size() + coordinates_[c]];
                    }
                }
            if (iteration == 30 || !cv::solve(J, residual, step, DECOMP_SVD))
                break;
            const double size = norm(step, NORM_INF), limit = 0.5;   // [rad]; a longer step may leave the valley
            for (int c = 0; c < 6; c++)
                joints[coordinates_[c]] += step(c) * std::min(1., limit / std::max(size, 1e-300));
            if (size < 1e-12)
                break;
        }
        return norm(residual, NORM_INF);
    }

    //! Adds whole turns so that no joint jumps from one frame to the next.
    void unwind(const std::vector<double>& before, std::vector<double>& joints) const
    {
        for (size_t i = 0; i < 6; i++)
        {
            double& q = joints[coordinates_[i]];
            q += 2 * CV_PI * cvRound((before[coordinates_[i]] - q) / (2 * CV_PI));
        }
    }

    int roll() const { return coordinates_[3]; }
    int insertion() const { return coordinates_[2]; }
    int jaw;

private:
    Ptr<ToolModel> model_;
    std::vector<int> coordinates_;   // of the six joints, from the base
    int links_[3];                   // of q4, q5 and q6
};

} // namespace

void importDaVinciJoints(const String& filename, const Ptr<ToolModel>& model, OutputArray jointTable)
{
    CV_Assert(model);
    const Recording recording = readRecording(filename);
    const InverseKinematics inverse(model);
    const int frames = (int)recording.jaws.size();
    Mat_<double> table(frames, 7);
    std::vector<double> before(7, 0.);
    for (int frame = 0; frame < frames; frame++)
    {
        std::vector<double> joints = before;
        double left = frame ? inverse.solve(recording, frame, joints) : DBL_MAX;
        for (int quarter = 0; quarter < 4 && left > TOLERANCE; quarter++)
        {
            joints.assign(7, 0.);
            joints[inverse.insertion()] = 0.12;   // [m]; in the middle of the slide
            joints[inverse.roll()] = quarter * CV_PI / 2;
            left = inverse.solve(recording, frame, joints);
        }
        if (left > TOLERANCE)
            importError(filename, format("frame %d: expected poses the model can take, it stays %.2g mm away: another tool, or another unit?",
                                         frame, left / UNIT));
        inverse.unwind(before, joints);
        joints[inverse.jaw] = std::max(recording.jaws[frame], 0.);   // motors press further on closed jaws
        Mat(joints).reshape(1, 1).copyTo(table.row(frame));
        before = joints;
    }
    table.copyTo(jointTable);
}

Matx44d importDaVinciHandEye(const String& filename, const String& key)
{
    const FileStorage file = openStorage(filename);
    return rigidInverse(readPose(file[key], filename, key));
}

}} // namespace cv::surgtrack

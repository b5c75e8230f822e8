// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/core/utils/filesystem.hpp"

namespace cv { namespace surgtrack {

namespace {

// One key of the description, with what an error needs to say where it is.
struct Key
{
    FileNode node;
    String path;    // file and key

    Key(const FileNode& n, const String& p) : node(n), path(p) {}
    Key operator[](const char* name) const
    {
        return Key(node.isMap() ? node[name] : FileNode(), path + (path[path.size() - 1] == ' ' ? "" : ".") + name);
    }
    bool there() const { return !node.empty(); }

    CV_NORETURN void fail(const char* expected) const
    {
        CV_Error(Error::StsParseError, format("%s %s, expected %s", path.c_str(), there() ? "is not valid" : "is missing", expected));
    }
    String text(const char* expected) const
    {
        if (!node.isString() || node.string().empty())
            fail(expected);
        return node.string();
    }
    double positive(const char* expected) const
    {
        const double value = node.isInt() || node.isReal() ? (double)node : 0;
        if (!(value > 0) || cvIsInf(value))
            fail(expected);
        return value;
    }
    int size(const char* expected) const
    {
        if (!node.isInt() || (int)node <= 0)
            fail(expected);
        return (int)node;
    }
    Mat matrix(const char* expected) const
    {
        Mat m;
        try
        {
            if (node.isMap())
                node >> m;
        }
        catch (const Exception&) {}
        if (!node.isMap() || m.channels() != 1)
            fail(expected);
        m.convertTo(m, CV_64F);
        return m;
    }
};

Matx44d readTransform(const Key& key)
{
    const char* expected = "a 4x4 matrix: rotation, translation [m], last row 0 0 0 1";
    const Mat m = key.matrix(expected);
    if (m.rows != 4 || m.cols != 4 || !isRigid(Matx44d(m.ptr<double>())))
        key.fail(expected);
    return Matx44d(m.ptr<double>());
}

CameraModel readCamera(const Key& key, Size imageSize)
{
    const Mat K = key["camera_matrix"].matrix("a 3x3 matrix");
    if (K.rows != 3 || K.cols != 3)
        key["camera_matrix"].fail("a 3x3 matrix");
    const char* expected = "a matrix of 0, 4, 5, 8 or 12 numbers";
    const Mat distortion = key["distortion_coefficients"].matrix(expected);
    const size_t n = distortion.total();
    if ((n != 0 && n != 4 && n != 5 && n != 8 && n != 12) || (n != 0 && distortion.rows != 1 && distortion.cols != 1))
        key["distortion_coefficients"].fail(expected);
    try
    {
        return CameraModel(K, distortion, imageSize);
    }
    catch (const Exception& e)
    {
        CV_Error(Error::StsParseError, format("%s: %s", key.path.c_str(), e.err.c_str()));
    }
}

String resolve(const String& folder, const String& path)
{
    const bool absolute = path[0] == '/' || path[0] == '\\' || (path.size() > 1 && path[1] == ':');
    return absolute ? path : utils::fs::join(folder, path);
}

} // namespace

void Sequence::readDescription(const String& folder, const String& filename, bool recorded)
{
    FileStorage file;
    try
    {
        file.open(filename, FileStorage::READ);
    }
    catch (const Exception& e)
    {
        CV_Error(Error::StsParseError, format("%s: can't be parsed: %s", filename.c_str(), e.err.c_str()));
    }
    if (!file.isOpened())
        CV_Error(Error::StsParseError, format("%s: can't be read, expected a file of cv::FileStorage", filename.c_str()));
    const Key root(file.root(), filename + ": key ");
    if (!root.node.isMap())
        CV_Error(Error::StsParseError, format("%s: expected the keys fps, image_width, ...", filename.c_str()));

    name_ = root["name"].there() ? root["name"].text("a text") : utils::fs::canonical(folder);
    name_ = name_.substr(name_.find_last_of("/\\") + 1);
    fps_ = root["fps"].positive("a number larger than 0 [frames/s]");
    const Size size(root["image_width"].size("a whole number larger than 0 [pixel]"),
                    root["image_height"].size("a whole number larger than 0 [pixel]"));
    left_ = readCamera(root["left"], size);
    if (recorded || root["left"]["video"].there())
        leftVideo_ = resolve(folder, root["left"]["video"].text("the path of a video"));
    if (root["right"].there())
    {
        right_ = readCamera(root["right"], size);
        if (recorded || root["right"]["video"].there())
            rightVideo_ = resolve(folder, root["right"]["video"].text("the path of a video"));
        right_T_left_ = readTransform(root["right_T_left"]);
    }
    const Key kinematics = root["kinematics"], truth = root["groundtruth"], keypoints = root["keypoints"];
    kinematicsFile_ = resolve(folder, kinematics.there() ? kinematics.text("the path of a CSV file") : String("kinematics.csv"));
    groundTruthFile_ = resolve(folder, truth.there() ? truth.text("the path of a CSV file") : String("groundtruth.csv"));
    keypointsFile_ = resolve(folder, keypoints.there() ? keypoints.text("the path of a CSV file") : String("keypoints.csv"));

    if (!root["tools"].node.isSeq() || root["tools"].node.size() == 0)
        root["tools"].fail("a list of at least one tool");
    for (size_t i = 0; i < root["tools"].node.size(); i++)
    {
        const Key key(root["tools"].node[(int)i], format("%s: key tools[%d]", filename.c_str(), (int)i));
        SequenceTool tool;
        tool.name = key["name"].text("a text");
        for (size_t j = 0; j < i; j++)
            if (tools_[j].name == tool.name)
                key["name"].fail("another name for each tool");
        if (tool.name.find_first_of(",\"\r\n") != String::npos)
            key["name"].fail("a name without comma, quote and line break");
        tool.model = resolve(folder, key["model"].text("the path of a tool file"));
        tool.nominal_T_base = readTransform(key["camera_T_base"]);
        tools_.push_back(tool);
    }
}

}} // namespace cv::surgtrack

// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <sstream>
#include "base/calib.hpp"
#include "files/joint_names.hpp"
#include "files/node_reader.hpp"
#include "lab/import/import_tool.hpp"

// Cameras from the calibration files of others.

namespace cv { namespace surgtrack {

namespace {

/* A camera from numbers of a file; distortion of more than twelve coefficients is fine if the further ones are 0. */
CameraModel makeCamera(const String& filename, const Mat& K, Mat D, Size size)
{
    D = D.empty() ? Mat() : Mat_<double>(D.clone().reshape(1, 1));
    if (D.cols > 12 && countNonZero(D.colRange(12, D.cols)) == 0)
        D = D.colRange(0, 12);
    try
    {
        return CameraModel(K, D, size);
    }
    catch (const Exception& e)
    {
        importError(filename, e.err);
    }
}

Matx44d makeTransform(const String& filename, const Mat& rotation, const Mat& translation, double unit)
{
    Mat R;
    if (rotation.total() == 3)
        Rodrigues(rotation, R);
    else
        R = rotation;
    const char* expected = "expected R, a rotation, and T, three numbers";
    if (R.total() != 9 || translation.total() != 3 || R.channels() != 1 || translation.channels() != 1)
        importError(filename, expected);
    R = Mat_<double>(R.clone().reshape(1, 3));
    const Mat_<double> t = Mat_<double>(translation.clone().reshape(1, 3)) * unit;
    const Matx44d T = rigidTransform(Matx33d(R.ptr<double>()), Vec3d(t(0), t(1), t(2)));
    if (!isRigid(T))
        importError(filename, expected);
    return nearestRigid(T);
}

//! Eyes that are too far apart, or exchanged.
void checkBaseline(const String& filename, const String& key, const Matx44d& right_T_left)
{
    const Vec3d t(right_T_left(0, 3), right_T_left(1, 3), right_T_left(2, 3));
    const double distance = norm(t);
    if (distance > 0.5 || distance < 1e-4)
        importError(filename, key + format(": the cameras are %g m apart, those of an endoscope some millimetres: %s", distance,
                                           distance > 0.5 ? "expected metres; millimetres?" : "is the unit right?"));
    if (t[0] > 0.5 * distance)
        importError(filename, key + ": the right camera stands to the left of the left one: expected x of T below 0; are the eyes exchanged?");
}

void append(const FileNode& node, Mat_<double>& m)
{
    for (FileNodeIterator it = node.begin(); node.isSeq() && it != node.end(); ++it)
        if ((*it).isSeq())
            append(*it, m);
        else
            m.push_back((*it).isInt() || (*it).isReal() ? (double)*it : DBL_MAX);
}

//! A column of the numbers of a list, or of one of lists; DBL_MAX where there is none.
Mat numbersOf(const FileNode& node)
{
    Mat_<double> m;
    append(node.isMap() ? node["data"] : node, m);
    return m;
}

//! A calibration file of ROS, or a CameraInfo message as `echo` prints it.
class CameraInfo
{
public:
    explicit CameraInfo(const String& filename) : filename_(filename), storage_(openYaml(filename)) {}

    CameraModel camera() const
    {
        String key;
        const Mat D = distortion(find("distortion_coefficients D d", key), key);
        Mat K = matrix("camera_matrix K k", 3, 3).clone();
        Size size(pixels("image_width width"), pixels("image_height height"));
        if (number("binning_x") > 1 || number("binning_y") > 1)
            importError(filename_, "key binning_x: expected a camera without binning, or one calibrated with it");
        // K is of the whole sensor, the images are of a part of it.
        if (number("roi", "width") > 0 && number("roi", "height") > 0)
        {
            K.at<double>(0, 2) -= number("roi", "x_offset");
            K.at<double>(1, 2) -= number("roi", "y_offset");
            size = Size(cvRound(number("roi", "width")), cvRound(number("roi", "height")));
        }
        return makeCamera(filename_, K, D, size);
    }

    //! @param keys names of the same in files and messages, separated by spaces
    Mat matrix(const String& keys, int rows, int cols) const
    {
        String key;
        const Mat m = numbersOf(find(keys, key));
        if ((int)m.total() != rows * cols || !checkRange(m, true, 0, -1e300, 1e300))
            importError(filename_, format("key %s: expected `data` with %d finite numbers", key.c_str(), rows * cols));
        return m.reshape(1, rows);
    }

    String name() const { return filename_; }

private:
    //! @param key the first name if there is none
    FileNode find(const String& keys, String& key) const
    {
        std::istringstream words(keys);
        for (String word; words >> word; )
        {
            if (key.empty() || !storage_[word].empty())
                key = word;
            if (!storage_[word].empty())
                break;
        }
        return storage_[key];
    }

    String model() const
    {
        const char* const keys[] = { "distortion_model", "camera_model" };
        for (int i = 0; i < 2; i++)
            if (storage_[keys[i]].isString() && (String)storage_[keys[i]] != "pinhole")
                return (String)storage_[keys[i]];
        return String();
    }

    //! k1, k2, p1, p2, then k3 or none, k4 to k6, s1 to s4; what follows has to be 0
    Mat distortion(const FileNode& node, const String& key) const
    {
        const String name = model();
        const bool plumbBob = name == "plumb_bob" || name == "radtan";
        if (!name.empty() && !plumbBob && name != "rational_polynomial")
            importError(filename_, "key distortion_model: expected plumb_bob or rational_polynomial, found `" + name
                        + "`; lenses of other models, such as fisheyes, are not supported");
        Mat D = numbersOf(node);
        const int n = (int)D.total(), most = plumbBob ? 5 : 12;
        if (n == 0 && node.isSeq())
            return Mat::zeros(5, 1, CV_64F);   // of a lens without, as drivers of rectified images say
        if ((n != 4 && n != 5 && n != 8 && n != 12 && n != 14) || !checkRange(D, true, 0, -1e300, 1e300))
            importError(filename_, "key " + key + ": expected `data` with 4, 5, 8, 12 or 14 finite numbers");
        if (name.empty() && n == 4)
            importError(filename_, "key distortion_model: missing, four coefficients may be those of a fisheye: expected plumb_bob");
        if (n > most && countNonZero(D.rowRange(most, n)) > 0)
            importError(filename_, format("key %s: expected zeros behind the first %d numbers", key.c_str(), most));
        return n > most ? D.rowRange(0, most).clone() : D;
    }

    double number(const char* key, const char* inside = 0) const
    {
        const FileNode node = inside && storage_[key].isMap() ? storage_[key][inside] : inside ? FileNode() : storage_[key];
        return node.isInt() || node.isReal() ? (double)node : 0;
    }

    int pixels(const String& keys) const
    {
        String key;
        const FileNode node = find(keys, key);
        if (!node.isInt() || (int)node <= 0)
            importError(filename_, "key " + key + ": expected a whole number larger than 0");
        return (int)node;
    }

    String filename_;
    FileStorage storage_;
};

//! Files of cv::FileStorage, and the names a matrix may have in them.
class Calibration
{
public:
    explicit Calibration(const std::vector<String>& files) : files_(files)
    {
        if (files.empty())
            CV_Error(Error::StsBadArg, "files: expected at least one calibration file");
        for (size_t i = 0; i < files.size(); i++)
        {
            const String text = readTextFile(files[i]);
            const bool plainYaml = text.find_first_of("%<{") != text.find_first_not_of(" \r\n");
            storages_.push_back(plainYaml ? openYaml(files[i]) : openStorage(files[i]));
        }
        for (size_t i = 0; i < files.size(); i++)
            refuseFisheye(storages_[i].root(), files[i]);
    }

    //! The first of these keys in any of the files; empty if there is none. @param names separated by spaces
    FileNode find(const String& names) const
    {
        std::istringstream words(names);
        String name;
        while (words >> name)
            for (size_t i = 0; i < storages_.size(); i++)
            {
                const FileNode root = storages_[i].root();
                for (FileNodeIterator it = root.begin(); it != root.end(); ++it)
                    if ((*it).name() == name || (name.size() > 2 && plain((*it).name()) == plain(name)))
                        return *it;
            }
        return FileNode();
    }

    Mat matrix(const String& names, bool needed) const
    {
        const FileNode node = find(names);
        Mat m = node.isSeq() ? numbersOf(node) : matrixOf(node);
        if (node.isSeq() && m.total() == 9) m = m.reshape(1, 3);   // as Python's lists are written
        if (m.empty() && (needed || !node.empty()))
            importError(files_[0], "expected a matrix of one of the names " + names + (files_.size() > 1 ? ", there or in the other files" : ""));
        return m.empty() ? m : Mat(Mat_<double>(m));
    }

    Size imageSize() const
    {
        const FileNode width = find("image_width image_Width width imageWidth"), height = find("image_height image_Height height imageHeight");
        if (width.isInt() && height.isInt())
            return Size((int)width, (int)height);
        const FileNode both = find("imageSize image_size img_size");
        return both.isSeq() && both.size() == 2 ? Size((int)both[0], (int)both[1]) : Size();
    }

    CameraModel camera(const String& matrixNames, const String& distortionNames, Size size) const
    {
        return makeCamera(files_[0], matrix(matrixNames, true), matrix(distortionNames, true), size);
    }

private:
    //! A key whatever the release writes large and where it has underscores.
    static String plain(const String& key)
    {
        String text = lowerCase(key);
        text.erase(std::remove(text.begin(), text.end(), '_'), text.end());
        return text;
    }

    //! Its four coefficients would pass for k1, k2, p1, p2.
    static void refuseFisheye(const FileNode& root, const String& filename)
    {
        const char* const others[] = { "fisheye", "equidistant", "kannala", "omni", "mei" };
        for (FileNodeIterator it = root.begin(); it != root.end(); ++it)
        {
            const String key = lowerCase((*it).name()), value = (*it).isString() ? lowerCase((String)*it) : String();
            const bool flag = key.find("fisheye") != String::npos && (value.empty() ? !(*it).isInt() || (int)*it != 0 : value != "false");
            bool named = key == "xi" || key == "xi1" || flag;
            for (int i = 0; i < 5; i++)
                named = named || (key.find("model") != String::npos && value.find(others[i]) != String::npos);
            if (named)
                importError(filename, "key " + (*it).name() + ": the fisheye model is not supported, expected a calibration of cv::calibrateCamera()");
        }
    }

    std::vector<String> files_;
    std::vector<FileStorage> storages_;
};

//! An INI file: the values of one section after the other.
class IniFile
{
public:
    explicit IniFile(const String& filename) : filename_(filename)
    {
        std::istringstream lines(readTextFile(filename));
        String line, section;
        while (std::getline(lines, line))
        {
            line = trim(line);
            const size_t equals = line.find('=');
            if (!line.empty() && line[0] == '[' && line[line.size() - 1] == ']')
                section = line.substr(1, line.size() - 2) + ".";
            else if (!line.empty() && line[0] != ';' && line[0] != '#' && equals != String::npos)
                values_[section + trim(line.substr(0, equals))] = trim(line.substr(equals + 1));
        }
    }

    double number(const String& key) const
    {
        const std::map<String, String>::const_iterator at = values_.find(key);
        if (at == values_.end())
            importError(filename_, "key " + key + ": missing");
        std::istringstream text(at->second);
        text.imbue(std::locale::classic());
        double value = 0;
        if (!(text >> value) || !(text >> std::ws).eof() || !(std::abs(value) < DBL_MAX))
            importError(filename_, "key " + key + ": expected a finite number, found `" + at->second + "`");
        return value;
    }

    CameraModel camera(const String& section) const
    {
        const Matx33d K(number(section + "fc_x"), 0, number(section + "cc_x"), 0, number(section + "fc_y"), number(section + "cc_y"), 0, 0, 1);
        // kc_0, kc_1, kc_4 are radial, kc_2 and kc_3 tangential: OpenCV's own order.
        Mat_<double> D(1, 5);
        for (int i = 0; i < 5; i++)
            D(i) = number(section + format("kc_%d", i));
        return makeCamera(filename_, Mat(K), D, Size(cvRound(number(section + "res_x")), cvRound(number(section + "res_y"))));
    }

private:
    static String trim(const String& text)
    {
        const size_t start = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
        return start == String::npos ? String() : text.substr(start, end - start + 1);
    }

    String filename_;
    std::map<String, String> values_;
};

} // namespace

CameraPair importCameraInfo(const std::vector<String>& files)
{
    if (files.empty() || files.size() > 2)
        CV_Error(Error::StsBadArg, "files: expected one calibration file, or two: left and right");
    CameraPair cameras;
    const CameraInfo left(files[0]);
    cameras.left = left.camera();
    if (files.size() == 1)
        return cameras;
    const CameraInfo right(files[1]);
    cameras.right = right.camera();
    // Between the rectified cameras, of the same focal length, there is a translation along x only: P(0, 3) = fx * Tx.
    const Mat_<double> P1 = left.matrix("projection_matrix P p", 3, 4), P2 = right.matrix("projection_matrix P p", 3, 4);
    if (!(P1(0, 0) > 0 && P2(0, 0) > 0) || P1(0, 3) != 0 || !(P2(0, 3) < 0))
        importError(right.name(), "key projection_matrix: expected that of the right camera of a stereo pair, data[3] = -fx * baseline "
                    "below 0, and in the left camera's file 0");
    Matx44d shift = Matx44d::eye();
    shift(0, 3) = P2(0, 3) / P2(0, 0);
    const Mat zero = Mat::zeros(3, 1, CV_64F);
    const Matx44d rectified_T_left = makeTransform(left.name(), left.matrix("rectification_matrix R r", 3, 3), zero, 1);
    const Matx44d rectified_T_right = makeTransform(right.name(), right.matrix("rectification_matrix R r", 3, 3), zero, 1);
    cameras.right_T_left = rigidInverse(rectified_T_right) * shift * rectified_T_left;
    checkBaseline(right.name(), "key projection_matrix", cameras.right_T_left);
    return cameras;
}

CameraPair importOpenCVCameras(const std::vector<String>& files, double unit, Size imageSize)
{
    const Calibration calibration(files);
    const Size written = calibration.imageSize();
    if (written.area() > 0 && imageSize.area() > 0 && written != imageSize)
        importError(files[0], format("calibrated for images of %dx%d pixels, expected %dx%d", written.width, written.height,
                                     imageSize.width, imageSize.height));
    const Size size = written.area() > 0 ? written : imageSize;
    if (size.area() <= 0)
        importError(files[0], "no image size in it (image_width, image_height): expected it to be given (imageSize)");
    CameraPair cameras;
    const String right = "M2 K2 cameraMatrix2 camera_matrix_2 camera_matrix_right cameraMatrixRight";
    cameras.left = calibration.camera("M1 K1 cameraMatrix1 camera_matrix_1 camera_matrix_left cameraMatrixLeft camera_matrix cameraMatrix M K mtx",
                                      "D1 distCoeffs1 dist_coeffs_1 distortion_coefficients_1 dist_coeffs_left distCoeffsLeft "
                                      "distortion_coefficients distCoeffs dist_coeffs dist_coeff D dist", size);
    if (calibration.find(right).empty())
        return cameras;
    cameras.right = calibration.camera(right, "D2 distCoeffs2 dist_coeffs_2 distortion_coefficients_2 dist_coeffs_right distCoeffsRight", size);
    const Mat R = calibration.matrix("R rotation rotation_matrix", true), T = calibration.matrix("T translation translation_vector", true);
    if (!(unit > 0 && unit < DBL_MAX))
        importError(files[0], format("the cameras are %g apart, in a unit the file does not say: expected it to be given (unit: metres, "
                                     "0.001 for millimetres)", norm(T)), Error::StsBadArg);
    cameras.right_T_left = makeTransform(files[0], R, T, unit);
    checkBaseline(files[0], "T", cameras.right_T_left);
    return cameras;
}

CameraPair importSurgPoseCameras(const String& filename)
{
    const IniFile file(filename);
    CameraPair cameras;
    cameras.left = file.camera("StereoLeft.");
    cameras.right = file.camera("StereoRight.");
    Mat_<double> R(3, 3), T(3, 1);
    for (int i = 0; i < 9; i++)
        R(i / 3, i % 3) = file.number(format("StereoRight.R_%d", i));
    for (int i = 0; i < 3; i++)
        T(i) = file.number(format("StereoRight.T_%d", i));
    cameras.right_T_left = makeTransform(filename, R, T, 1e-3);
    return cameras;
}

}} // namespace cv::surgtrack

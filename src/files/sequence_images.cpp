// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/imgcodecs.hpp"
#include "opencv2/surgtrack/fields.hpp"
#include "opencv2/surgtrack/sequence.hpp"
#include "files/node_reader.hpp"
#include "files/text_file.hpp"

// Cameras and videos, and the eyes' images in the frames of these.

namespace cv { namespace surgtrack {

namespace {

//! The number of the word that stands there, joined by _ or -; 0 if there is none.
int choice(const NodeReader& node, const char* const (&words)[3])
{
    if (!node.isThere())
        return 0;
    const String all = format("%s, %s or %s", words[0], words[1], words[2]);
    String text = node.text(all.c_str());
    std::replace(text.begin(), text.end(), '-', '_');
    for (int i = 0; i < 3; i++)
        if (text == words[i])
            return i;
    node.expected(all);
}

CameraModel readCamera(const NodeReader& node, Size imageSize)
{
    const NodeReader matrix = node["camera_matrix"], coefficients = node["distortion_coefficients"];
    const Mat K = matrix.matrix("a 3x3 matrix");
    if (K.rows != 3 || K.cols != 3)
        matrix.expected("a 3x3 matrix");
    const char* expected = "a matrix of 0, 4, 5, 8 or 12 numbers";
    Mat distortion = coefficients.matrix(expected).clone();
    if (distortion.total() == 14 && countNonZero(distortion.reshape(1, 14).rowRange(12, 14)) == 0)   // as cv::calibrateCamera() may write it
        distortion = distortion.reshape(1, 14).rowRange(0, 12).clone();
    const size_t n = distortion.total();
    if ((n != 0 && n != 4 && n != 5 && n != 8 && n != 12) || (n != 0 && distortion.rows != 1 && distortion.cols != 1))
        coefficients.expected(expected);
    try
    {
        return CameraModel(K, distortion, imageSize);
    }
    catch (const Exception& e)
    {
        node.fail(e.err);
    }
}

} // namespace

//! Cameras, videos, and where the images are in them.
void Sequence::readImages(const NodeReader& root, bool recorded)
{
    static const char* const layouts[] = { "separate", "side_by_side", "top_bottom" };
    static const char* const fields[] = { "none", "top_first", "bottom_first" };
    const char* const video = "the path of a video";
    const char* const mask = "the path of an image";
    const NodeReader left = root["left"], right = root["right"];
    left.checkSpelling({"video", "camera_matrix", "distortion_coefficients", "mask"});
    right.checkSpelling({"video", "camera_matrix", "distortion_coefficients", "mask"});
    const Size size(root["image_width"].count("a whole number larger than 0 [pixel]"),
                    root["image_height"].count("a whole number larger than 0 [pixel]"));
    layout_ = choice(root["layout"], layouts);
    fields_ = choice(root["fields"], fields);
    left_ = readCamera(left, size);
    if (recorded || left.has("video"))
        leftVideo_ = left["video"].path(video);
    if (right.isThere())
    {
        right_ = readCamera(right, size);
        if (layout_ != LAYOUT_SEPARATE)
            rightVideo_ = leftVideo_;
        else if (recorded || right.has("video"))
            rightVideo_ = right["video"].path(video);
        if (right.has("video") && right["video"].path(video) != rightVideo_)
            right["video"].expected("none, or that of the left eye: by the key layout both eyes are in one file");
    }
    for (int eye = 0; eye < 2; eye++)   // one of its own, or that of both
    {
        const NodeReader own = (eye ? right : left)["mask"], node = own.isThere() ? own : root["mask"];
        if (node.isThere())
            masks_[eye] = node.path(mask);
    }
}

Size Sequence::frameSize() const
{
    const Size eye = left_.imageSize();
    return Size(eye.width * (layout_ == LAYOUT_SIDE_BY_SIDE ? 2 : 1), eye.height * (layout_ == LAYOUT_TOP_BOTTOM ? 2 : 1));
}

void Sequence::eyeImage(InputArray _frame, OutputArray image, int eye, int field) const
{
    const Mat frame = _frame.getMat();
    CV_Check(eye, eye >= 0 && eye <= 1, "eye must be 0 or 1");
    CV_Check(field, field >= 0 && field < imagesPerFrame(), "field must be less than imagesPerFrame()");
    const Size size = left_.imageSize(), whole = frameSize();
    if (frame.size() != whole)
        CV_Error(Error::StsUnmatchedSizes, format("%s: a frame of the video has %dx%d pixels, expected %dx%d by image_width, image_height%s", filename_.c_str(),
                                                  frame.cols, frame.rows, whole.width, whole.height, layout_ ? " of an eye, and layout" : ""));
    const Point corner(eye && layout_ == LAYOUT_SIDE_BY_SIDE ? size.width : 0, eye && layout_ == LAYOUT_TOP_BOTTOM ? size.height : 0);
    const Mat part = frame(Rect(corner, size));
    if (fields_)
    {
        const bool topFirst = (fields_ == 1) == (corner.y % 2 == 0);   // of the eye's rows
        if (field == 0) splitFields(part, topFirst, image, noArray());
        else splitFields(part, !topFirst, image, noArray());
    }
    else if (layout_) part.copyTo(image);
    else image.assign(frame);
}

Mat Sequence::mask(int eye) const
{
    CV_Check(eye, eye >= 0 && eye <= 1, "eye must be 0 or 1");
    const String& filename = masks_[eye];
    if (filename.empty()) return Mat();
    const Mat mask = isRegularFile(filename) ? imread(filename, IMREAD_GRAYSCALE) : Mat();
    const Size size = left_.imageSize();
    if (mask.empty())
        CV_Error(Error::StsObjectNotFound, format("%s: key mask: %s can't be read, expected an image", filename_.c_str(), filename.c_str()));
    if (mask.size() != size)
        CV_Error(Error::StsParseError, format("%s: key mask: %s has %dx%d pixels, expected %dx%d as the images", filename_.c_str(), filename.c_str(),
                                              mask.cols, mask.rows, size.width, size.height));
    return mask;
}

}} // namespace cv::surgtrack

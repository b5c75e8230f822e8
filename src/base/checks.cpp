// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/checks.hpp"

namespace cv { namespace surgtrack {

void checkFinite(InputArray values, const char* name)
{
    if (!checkRange(values)) CV_Error(Error::StsBadArg, format("%s holds a value that is not finite", name));
}

Mat asRows(InputArray values, int channels, const char* name)
{
    Mat m = values.getMat();
    if (m.empty()) return Mat(0, channels, CV_64F);
    if (m.depth() != CV_64F && m.depth() != CV_32F)
        CV_Error(Error::StsBadArg, format("%s must be floating point, is %s", name, typeToString(m.type()).c_str()));
    if (!m.isContinuous()) m = m.clone();
    const bool vectorOfPoints = m.channels() == channels && (m.rows == 1 || m.cols == 1);
    const bool rows = m.channels() == 1 && (m.cols == channels || (m.rows == channels && m.cols == 1));
    if (m.dims > 2 || (!vectorOfPoints && !rows))
        CV_Error(Error::StsBadSize, format("%s must be N x %d or N points of %d channels, is %d x %d with %d channels", name, channels,
                                           channels, m.rows, m.cols, m.channels()));
    m = m.reshape(1, int(m.total() * m.channels() / channels));
    if (m.depth() != CV_64F) m.convertTo(m, CV_64F);
    checkFinite(m, name);
    return m;
}

void checkImage(const Mat& image, const char* name)
{
    if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3))
        CV_Error(Error::StsUnsupportedFormat, format("%s must be CV_8UC1 or CV_8UC3 and not empty, is %s of %d x %d", name,
                                                     typeToString(image.type()).c_str(), image.cols, image.rows));
}

}} // namespace cv::surgtrack

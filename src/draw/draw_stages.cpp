// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/draw.hpp"
#include "base/geometry.hpp"

// Pictures of what the stages see: orientations, templates, similarities, matches, the geometric context, edges.

namespace cv { namespace surgtrack {

namespace {

const int bins = 8;
const int subpixelBits = 4;   // of what OpenCV draws
const Scalar black(0, 0, 0), white(255, 255, 255), grey(160, 160, 160);

Mat pictureOf(InputOutputArray image)
{
    const Mat result = image.getMat();
    CV_CheckTypeEQ(result.type(), CV_8UC3, "image must be BGR");
    CV_Assert(!result.empty() && "image must not be empty");
    return result;
}

// hue: 0..1
Scalar colorOfHue(double hue, double saturation, double value)
{
    const double h = 6 * (hue - std::floor(hue));
    const double channels[3] = {5 + h, 3 + h, 1 + h};   // R, G, B
    double rgb[3];
    for (int i = 0; i < 3; i++)
    {
        const double k = std::fmod(channels[i], 6);
        rgb[i] = 255 * value * (1 - saturation * std::max(0., std::min(1., std::min(k, 4 - k))));
    }
    return Scalar(cvRound(rgb[2]), cvRound(rgb[1]), cvRound(rgb[0]));
}

// Sizes of dots and lines are made for images 720 pixels wide.
double penScale(const Mat& image) { return std::max(1., image.cols / double(referenceWidth)); }

Point fine(const Point2d& p) { return Point(cvRound(p.x * (1 << subpixelBits)), cvRound(p.y * (1 << subpixelBits))); }

void drawLine(Mat& image, const Point2d& a, const Point2d& b, const Scalar& color, int thickness)
{
    const double far = 1e6;   // OpenCV's coordinates have 32 bits, with the fraction
    if (std::abs(a.x) < far && std::abs(a.y) < far && std::abs(b.x) < far && std::abs(b.y) < far)
        line(image, fine(a), fine(b), color, thickness, LINE_AA, subpixelBits);
}

void drawDot(Mat& image, const Point2d& p, double radius, const Scalar& color, bool filled, int thickness)
{
    if (!Rect2d(-1e4, -1e4, image.cols + 2e4, image.rows + 2e4).contains(p)) return;
    const int r = cvRound(radius * (1 << subpixelBits));
    circle(image, fine(p), r, black, filled ? FILLED : thickness + 2, LINE_AA, subpixelBits);   // dark rim: to be seen on any background
    circle(image, fine(p), filled ? std::max(1, r - (thickness << subpixelBits)) : r, color, filled ? FILLED : thickness, LINE_AA, subpixelBits);
}

// The nearest bin of a direction modulo 180 degrees.
int binOf(double x, double y)
{
    const double angle = std::atan2(y, x) * bins / CV_PI;
    return (cvRound(angle) + 2 * bins) % bins;
}

} // namespace

Scalar orientationColor(int bin)
{
    CV_Check(bin, bin >= 0 && bin < bins, "bin must be 0..7");
    return colorOfHue(bin / double(bins), 1, 1);
}

Scalar partColor(int part)
{
    CV_CheckGE(part, 0, "part must not be negative");
    const double goldenRatio = 0.6180339887498949;   // its multiples spread evenly
    return colorOfHue(part * goldenRatio, part % 2 ? 0.65 : 1, 1);
}

void drawOrientations(InputOutputArray _image, InputArray _orientations)
{
    Mat image = pictureOf(_image);
    const Mat orientations = _orientations.getMat();
    CV_CheckTypeEQ(orientations.type(), CV_8UC1, "orientations must be bit sets");
    CV_Assert(orientations.size() == image.size() && "orientations must have the image's size");
    Vec3b colors[256];
    for (int bits = 1; bits < 256; bits++)
    {
        Scalar sum;
        int n = 0;
        for (int bin = 0; bin < bins; bin++)
            if (bits & (1 << bin))
            {
                sum += orientationColor(bin);
                n++;
            }
        for (int c = 0; c < 3; c++) colors[bits][c] = saturate_cast<uchar>(sum[c] / n);
    }
    for (int y = 0; y < image.rows; y++)
    {
        const uchar* bits = orientations.ptr(y);
        Vec3b* row = image.ptr<Vec3b>(y);
        for (int x = 0; x < image.cols; x++)
            if (bits[x]) row[x] = colors[bits[x]];
    }
}

void drawOrientationLegend(InputOutputArray _image, Point centre, int radius)
{
    Mat image = pictureOf(_image);
    CV_Check(radius, radius > 0 && radius < 10000, "radius must be positive");
    circle(image, centre, radius + std::max(2, radius / 12), white, FILLED, LINE_AA);
    const Rect box = Rect(centre.x - radius, centre.y - radius, 2 * radius + 1, 2 * radius + 1) & Rect(Point(), image.size());
    for (int y = box.y; y < box.y + box.height; y++)
        for (int x = box.x; x < box.x + box.width; x++)
        {
            const Point d = Point(x, y) - centre;
            if (d.x * d.x + d.y * d.y > radius * radius) continue;
            const Scalar color = orientationColor(binOf(d.x, d.y));
            image.at<Vec3b>(y, x) = Vec3b(uchar(color[0]), uchar(color[1]), uchar(color[2]));
        }
}

void drawTemplate(InputOutputArray _image, const PartTemplate& partTemplate, Point anchor, int pixelSize)
{
    Mat image = pictureOf(_image);
    CV_Check(pixelSize, pixelSize > 0 && pixelSize < 1000, "pixelSize must be positive");
    const Rect all(Point(), image.size());
    for (size_t i = 0; i < partTemplate.features.size(); i++)
    {
        const TemplateFeature& f = partTemplate.features[i];
        const Rect square = Rect(anchor.x + f.x * pixelSize - pixelSize / 2, anchor.y + f.y * pixelSize - pixelSize / 2, pixelSize, pixelSize) & all;
        if (!square.empty()) image(square).setTo(orientationColor(f.bin));
    }
}

void drawSimilarity(InputArray _similarity, const PartTemplate& partTemplate, OutputArray picture)
{
    const Mat similarity = _similarity.getMat();
    CV_CheckTypeEQ(similarity.type(), CV_16UC1, "similarity must be sums over features");
    if (partTemplate.features.empty()) CV_Error(Error::StsBadArg, "partTemplate has no features");
    Mat grey8;
    similarity.convertTo(grey8, CV_8U, 255. / (4 * partTemplate.features.size()));   // a feature adds 4 at most
    applyColorMap(grey8, picture, COLORMAP_INFERNO);
}

void drawMatches(InputOutputArray _image, const std::vector<PartMatch>& matches, bool filled)
{
    Mat image = pictureOf(_image);
    const double scale = penScale(image);
    const int thickness = std::max(1, cvRound(scale));
    for (size_t i = matches.size(); i-- > 0;)   // the most similar ones on top
    {
        const Scalar color = partColor(matches[i].part);
        drawLine(image, matches[i].predictedPoint, matches[i].imagePoint, color, thickness);
        drawDot(image, matches[i].imagePoint, scale * (2 + 5 * matches[i].similarity), color, filled, thickness);
    }
}

namespace {

struct PolarAxes
{
    PolarAxes(const Point2d& c, const Point2d& onAxis) : centre(c), axis(std::atan2(onAxis.y - c.y, onAxis.x - c.x)) {}
    Point2d at(double angle, double radius) const { return centre + Point2d(std::cos(axis + angle), std::sin(axis + angle)) * radius; }
    double angle(const Point2d& p) const { return std::atan2(p.y - centre.y, p.x - centre.x) - axis; }
    Point2d centre;
    double axis;
};

// The zone of a point of the drawing, as the verifier has it, at its place in one of the grids.
void drawZone(Mat& image, const PolarAxes& grid, double angle, double radius, const GeometricContextVerifier::Params& params, const Scalar& color, int thickness)
{
    double angle0 = angle - params.zoneAngle / 2, radius0 = radius - params.zoneRadius / 2;
    if (!params.centredZones)
    {
        const double positive = angle - 2 * CV_PI * std::floor(angle / (2 * CV_PI));
        angle0 = std::floor(positive / params.zoneAngle) * params.zoneAngle;
        radius0 = std::floor(radius / params.zoneRadius) * params.zoneRadius;
    }
    const int pieces = 12;   // of an arc
    std::vector<Point> outline;
    for (int side = 0; side < 2; side++)
        for (int i = 0; i <= pieces; i++)
            outline.push_back(fine(grid.at(angle0 + params.zoneAngle * (side ? pieces - i : i) / pieces,
                                           std::max(0., radius0 + (side ? params.zoneRadius : 0)))));
    polylines(image, outline, true, black, thickness + 2, LINE_AA, subpixelBits);
    polylines(image, outline, true, color, thickness, LINE_AA, subpixelBits);
}

} // namespace

void drawGeometricContext(InputOutputArray _image, const std::vector<PartMatch>& matches, const std::vector<PartMatch>& inliers,
                          const std::vector<PartMatch>& sample, bool predicted, const GeometricContextVerifier::Params& params)
{
    Mat image = pictureOf(_image);
    CV_Assert(sample.empty() || sample.size() == 2);
    CV_Check(params.zoneAngle, params.zoneAngle > 0 && params.zoneRadius > 0, "Params::zoneAngle and zoneRadius must be positive");
    const double scale = penScale(image);
    const int thickness = std::max(1, cvRound(scale));
    if (!sample.empty())
    {
        const PolarAxes drawing(sample[0].predictedPoint, sample[1].predictedPoint), seen(sample[0].imagePoint, sample[1].imagePoint);
        const PolarAxes& grid = predicted ? drawing : seen;
        double reach = 0;   // of the parts
        for (size_t i = 0; i < inliers.size(); i++) reach = std::max(reach, norm(inliers[i].predictedPoint - drawing.centre));
        const int rings = std::max(1, cvCeil(reach / params.zoneRadius)), rays = std::max(1, cvRound(2 * CV_PI / params.zoneAngle));
        Mat faint = image.clone();
        for (int i = 1; i <= rings; i++)
            circle(faint, fine(grid.centre), cvRound(i * params.zoneRadius * (1 << subpixelBits)), white, thickness, LINE_AA, subpixelBits);
        for (int i = 0; i < rays; i++) drawLine(faint, grid.centre, grid.at(i * params.zoneAngle, rings * params.zoneRadius), white, thickness);
        addWeighted(faint, 0.4, image, 0.6, 0, image);
        drawLine(image, grid.centre, grid.at(0, rings * params.zoneRadius), white, 2 * thickness);
        for (size_t i = 0; i < inliers.size(); i++)
        {
            if (inliers[i].part == sample[0].part || inliers[i].part == sample[1].part) continue;
            const Point2d& p = inliers[i].predictedPoint;
            drawZone(image, grid, drawing.angle(p), norm(p - drawing.centre), params, partColor(inliers[i].part), thickness);
        }
    }
    for (int pass = 0; pass < 2; pass++)
    {
        const std::vector<PartMatch>& drawn = pass ? inliers : matches;
        for (size_t i = 0; i < drawn.size(); i++)
            drawDot(image, predicted ? drawn[i].predictedPoint : drawn[i].imagePoint, (pass ? 5 : 4) * scale, partColor(drawn[i].part), pass == 1, thickness);
    }
}

void drawContour(InputOutputArray _image, const std::vector<ContourPoint>& points, double worst, double gain)
{
    Mat image = pictureOf(_image);
    CV_Check(worst, worst > 0 && worst < DBL_MAX, "worst must be positive");
    CV_Check(gain, gain > 0 && gain < DBL_MAX, "gain must be positive");
    const double scale = penScale(image);
    const int thickness = std::max(1, cvRound(scale));
    for (size_t i = 0; i < points.size(); i++)
    {
        const ContourPoint& c = points[i];
        const Scalar color = c.found ? colorOfHue((1 - std::min(1., std::abs(c.offset) / worst)) / 3, 1, 1) : grey;   // from green to red
        if (c.found) drawLine(image, c.imagePoint, c.imagePoint + c.normal * (gain * c.offset), color, 2 * thickness);
        drawDot(image, c.imagePoint, 2 * scale, color, true, 0);
    }
}

}} // namespace cv::surgtrack

// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/fields.hpp"
#include "opencv2/surgtrack/part_finder.hpp"
#include "base/checks.hpp"
#include "detect/image_state.hpp"
#include "base/geometry.hpp"
#include "model/camera.hpp"

namespace cv { namespace surgtrack {

PartWindows::PartWindows(double _halfWidth) : halfWidth(_halfWidth) {}

FoundParts::FoundParts() : imageTime(0), matchTime(0), verifyTime(0) {}

double meanSimilarity(const std::vector<PartMatch>& matches)
{
    double sum = 0;
    for (size_t i = 0; i < matches.size(); i++) sum += matches[i].similarity;
    return matches.empty() ? 0 : sum / double(matches.size());
}

namespace {

// Gradients of a pixel reach so far: blur 3, Sobel and vote 1 each.
const int gradientReach = 5;

// Adds the time since the last one to a stage's.
class Lap
{
public:
    Lap() : last_(getTickCount()) {}
    double operator()()
    {
        const int64 now = getTickCount(), ticks = now - last_;
        last_ = now;
        return double(ticks) / getTickFrequency();
    }

private:
    int64 last_;
};

class PartFinderImpl CV_FINAL : public PartFinder
{
public:
    PartFinderImpl(const CameraModel& full, const Ptr<PartTemplateRenderer>& templates, const Ptr<QGOMatcher>& matcher, const Matx44d& eye_T_camera)
        : imageSize_(full.imageSize()), reduction_(std::max(1, imageSize_.width / referenceWidth)), camera_(reduceCamera(full, reduction_)),
          pixelScale_(camera_.imageSize().width / double(referenceWidth)), eye_T_camera_(eye_T_camera), moved_(eye_T_camera != Matx44d::eye()), interlaced_(false),
          templates_(templates), matcher_(matcher)
    {
        CV_Assert(templates);
        CV_Assert(matcher);
        CV_Assert(isRigid(eye_T_camera) && "eye_T_camera: rigid");
    }

    Size imageSize() const CV_OVERRIDE { return imageSize_; }
    int reduction() const CV_OVERRIDE { return reduction_; }
    const CameraModel& camera() const CV_OVERRIDE { return camera_; }
    double pixelScale() const CV_OVERRIDE { return pixelScale_; }
    const Matx44d& eye_T_camera() const CV_OVERRIDE { return eye_T_camera_; }
    const Ptr<PartTemplateRenderer>& templates() const CV_OVERRIDE { return templates_; }

    void draw(const std::vector<ToolView>& views, int tool, PartDrawing& drawing, double scale, double rotation, bool alone) CV_OVERRIDE;
    void setImage(const Mat& image) CV_OVERRIDE;
    void release() CV_OVERRIDE { image_.release(); }
    void setMask(const Mat& mask) CV_OVERRIDE;
    bool isInterlaced() const CV_OVERRIDE { return interlaced_; }
    bool sees(const Point2d& p) const CV_OVERRIDE { return visible_.sees(enlarged(p)); }
    double change(const Rect& region) const CV_OVERRIDE
    {
        return samples_.change(Rect(region.x * reduction_, region.y * reduction_, region.width * reduction_, region.height * reduction_));
    }
    const Mat& pixels(const Rect& region) CV_OVERRIDE;
    void prepare(const Rect& region) CV_OVERRIDE;
    void find(const PartDrawing& drawing, const PartWindows& windows, GeometricContextVerifier& verifier, FoundParts& found) CV_OVERRIDE;

private:
    Point2d enlarged(const Point2d& p) const { return Point2d((p.x + 0.5) * reduction_ - 0.5, (p.y + 0.5) * reduction_ - 0.5); }
    void setMatcherImage(const Rect& region);
    const std::vector<PartTemplate>& withoutHidden(const PartDrawing& drawing);
    Rect place(const PartDrawing& drawing, const PartWindows& windows, std::vector<Rect>& placed);

    Size imageSize_;
    int reduction_;
    CameraModel camera_;
    double pixelScale_;
    Matx44d eye_T_camera_;
    bool moved_;             // eye_T_camera is not unit
    bool interlaced_;        // the image is
    Ptr<PartTemplateRenderer> templates_;
    Ptr<QGOMatcher> matcher_;
    Mat image_, reduced_;    // reduced: up to date where it was asked for
    Mat field_;              // of an interlaced image
    VisibleRegion visible_;  // of the images given
    ImageSamples samples_;
    Mat mask_;               // of what is matched
    std::vector<PartTemplate> seen_;   // templates without what is hidden
    Rect prepared_;          // of it, for matching
    std::vector<Point2d> expected_;   // a template; memory of find()
};

void PartFinderImpl::draw(const std::vector<ToolView>& views, int tool, PartDrawing& drawing, double scale, double rotation, bool alone)
{
    drawing.views = views;
    for (int i = 0; i < int(views.size()); i++)
    {
        if (alone && i != tool) drawing.views[i].base_T_link.clear();
        if (moved_) drawing.views[i].camera_T_base = eye_T_camera_ * drawing.views[i].camera_T_base;
    }
    templates_->render(camera_, drawing.views, tool, drawing.templates, scale, rotation);
    templates_->swapRendering(drawing.rendering);
}

void PartFinderImpl::setImage(const Mat& image)
{
    checkImage(image);
    CV_Assert(image.size() == imageSize_ && "image: of the camera's size");
    image_ = image;
    interlaced_ = cv::surgtrack::isInterlaced(image);
    if (interlaced_)
    {
        splitFields(image, true, field_, noArray());
        image_ = field_;
    }
    visible_.look(image_);
    samples_.look(image_, reduction_);
    prepared_ = Rect();
}

// In tiles so narrow that resize() has its tables on the stack and wakes no other thread.
const Mat& PartFinderImpl::pixels(const Rect& region)
{
    CV_Assert(!image_.empty() && "setImage() comes first");
    if (reduction_ == 1) return image_;
    if (region.empty()) return reduced_;
    reduced_.create(camera_.imageSize(), image_.type());
    const Rect reach(region.x - gradientReach, region.y - gradientReach, region.width + 2 * gradientReach, region.height + 2 * gradientReach);
    const Rect area = reach & Rect(Point(), reduced_.size());
    for (int x = area.x; x < area.x + area.width; x += 64)
    {
        const Rect tile(x, area.y, std::min(64, area.x + area.width - x), area.height);
        const Rect source(tile.x * reduction_, tile.y * reduction_, tile.width * reduction_, tile.height * reduction_);
        resize(image_(source), reduced_(tile), tile.size(), 0, 0, INTER_AREA);
    }
    return reduced_;
}

void PartFinderImpl::prepare(const Rect& region)
{
    const Rect all(Point(), camera_.imageSize());
    prepared_ = region.empty() ? all : region & all;
    setMatcherImage(prepared_);
}

void PartFinderImpl::setMatcherImage(const Rect& region)
{
    if (!visible_.isPartial())
    {
        matcher_->setImage(pixels(region), region);
        return;
    }
    mask_.create(camera_.imageSize(), CV_8UC1);
    for (int y = region.y; y < region.y + region.height; y++)
        for (int x = region.x; x < region.x + region.width; x++) mask_.at<uchar>(y, x) = sees(Point2d(x, y)) ? 255 : 0;
    matcher_->setImage(pixels(region), region, mask_);
}

void PartFinderImpl::setMask(const Mat& mask)
{
    if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != imageSize_))
        CV_Error(Error::StsBadArg, format("mask must be CV_8UC1 of %d x %d, is %s of %d x %d", imageSize_.width, imageSize_.height,
                                          typeToString(mask.type()).c_str(), mask.cols, mask.rows));
    visible_.setMask(mask);
}

// Features where nothing can be seen, as far as it is known where the part is, tell nothing.
const std::vector<PartTemplate>& PartFinderImpl::withoutHidden(const PartDrawing& drawing)
{
    if (!visible_.isPartial()) return drawing.templates;
    seen_ = drawing.templates;
    for (size_t i = 0; i < seen_.size(); i++)
    {
        const Point2d shift = expected_[i] - seen_[i].imagePoint + Point2d(seen_[i].anchor);
        std::vector<TemplateFeature>& features = seen_[i].features;
        size_t kept = 0;
        for (size_t k = 0; k < features.size(); k++)
            if (sees(shift + Point2d(features[k].x, features[k].y))) features[kept++] = features[k];
        if (2 * kept < features.size()) kept = 0;   // the rest is not what was chosen to tell the part
        features.resize(kept);
    }
    return seen_;
}

// The windows, and what of the image they and the templates in them cover.
Rect PartFinderImpl::place(const PartDrawing& drawing, const PartWindows& windows, std::vector<Rect>& placed)
{
    const Rect all(Point(), camera_.imageSize());
    Rect roi;
    placed.clear();
    expected_.clear();
    for (size_t i = 0; i < drawing.templates.size(); i++)
    {
        const PartTemplate& t = drawing.templates[i];
        double hx = windows.halfWidth, hy = windows.halfWidth;
        if (!windows.deviations.empty())
        {
            const Point2d& deviation = windows.deviations[t.part];
            hx = std::min(std::max(hx, 3 * deviation.x), 4 * windows.halfWidth);
            hy = std::min(std::max(hy, 3 * deviation.y), 4 * windows.halfWidth);
        }
        const Point2d expected = windows.expected.empty() ? t.imagePoint : windows.expected[t.part];
        expected_.push_back(expected);
        const Point2d at = Point2d(t.anchor) + Point2d(cvRound(expected.x - t.imagePoint.x), cvRound(expected.y - t.imagePoint.y));
        placed.push_back(Rect(cvRound(at.x - hx), cvRound(at.y - hy), cvRound(2 * hx) + 1, cvRound(2 * hy) + 1) & all);
        const Rect& w = placed.back();
        if (w.empty()) continue;
        const Rect reach = Rect(w.x + t.bounds.x, w.y + t.bounds.y, w.width + t.bounds.width, w.height + t.bounds.height) & all;
        roi = roi.empty() ? reach : roi | reach;
    }
    return roi;
}

void PartFinderImpl::find(const PartDrawing& drawing, const PartWindows& windows, GeometricContextVerifier& verifier, FoundParts& found)
{
    found.matches.clear();
    found.inliers.clear();
    found.sample.clear();
    found.imageTime = found.matchTime = found.verifyTime = 0;
    const Rect roi = place(drawing, windows, found.windows);
    if (roi.empty()) return;
    Lap lap;
    if ((roi & prepared_) != roi)   // what a find() before prepared does not count: nothing depends on what was looked for before
    {
        prepared_ = Rect();
        setMatcherImage(roi);
    }
    found.imageTime = lap();
    const std::vector<PartTemplate>& templates = withoutHidden(drawing);
    for (size_t i = 0; i < templates.size(); i++)
        if (templates[i].features.empty()) found.windows[i] = Rect();
    matcher_->match(templates, found.windows, found.matches);
    for (size_t i = 0; i < found.matches.size(); i++) found.matches[i].predictedPoint = expected_[found.matches[i].templateIndex];
    found.matchTime = lap();
    verifier.verify(found.matches, found.inliers);
    verifier.copySample(found.sample);
    found.verifyTime = lap();
}

} // namespace

Ptr<PartFinder> PartFinder::create(const CameraModel& camera, const Ptr<PartTemplateRenderer>& templates, const Ptr<QGOMatcher>& matcher,
                                   const Matx44d& eye_T_camera)
{
    return makePtr<PartFinderImpl>(camera, templates, matcher, eye_T_camera);
}

}} // namespace cv::surgtrack

// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/fields.hpp"
#include "opencv2/surgtrack/part_finder.hpp"
#include "base/checks.hpp"
#include "detect/enlarge.hpp"
#include "detect/image_state.hpp"
#include "detect/template_copies.hpp"
#include "base/geometry.hpp"
#include "model/camera.hpp"

namespace cv { namespace surgtrack {

PartDrawing::PartDrawing() : enlargement(1) {}

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

/* Blur takes the details of small tools. On rendered sequences reduced to a third, with wrists of 21 to 33 pixels, twice the size takes
   the mean error from 0.038-0.072 to 0.016-0.042 rad, and of real stills so small 56 tools are found in place of 38 of 60; reduced to
   half, with 31 to 50 pixels, it changes little for the better or the worse. A tool that is enlarged stays so until it is a tenth larger. */
const double wristWidth = 0.0084;                  // of instruments of 8 mm [m]
const double smallWrist = 30, largeWrist = 33;     // [pixel]

const double partsMargin = 0.012;                  // about keypoints: half a template's box, and what a lens bends [m]

Point2d enlarged(const Point2d& p, double factor) { return Point2d((p.x + 0.5) * factor - 0.5, (p.y + 0.5) * factor - 0.5); }

Rect enlarged(const Rect& r, int factor) { return Rect(r.x * factor, r.y * factor, r.width * factor, r.height * factor); }

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
          cameraOfSmall_(enlargeCamera(camera_, 2)),
          pixelScale_(camera_.imageSize().width / double(referenceWidth)), eye_T_camera_(eye_T_camera), moved_(eye_T_camera != Matx44d::eye()), interlaced_(false),
          templates_(templates), matcher_(matcher), preparedEnlargement_(1)
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
    void takeBack() CV_OVERRIDE
    {
        release();
        visible_ = before_.visible;
        samples_ = before_.samples;
        small_ = before_.small;
        painted_[0] = painted_[1] = -1;
    }
    void setMask(const Mat& mask) CV_OVERRIDE;
    bool isInterlaced() const CV_OVERRIDE { return interlaced_; }
    bool sees(const Point2d& p) const CV_OVERRIDE { return visible_.sees(enlarged(p, reduction_)); }
    double change(const Rect& region) const CV_OVERRIDE
    {
        return samples_.change(enlarged(region, reduction_));
    }
    const Mat& pixels(const Rect& region) CV_OVERRIDE;
    void prepare(const Rect& region) CV_OVERRIDE;
    void find(const PartDrawing& drawing, const PartWindows& windows, GeometricContextVerifier& verifier, FoundParts& found) CV_OVERRIDE;

private:
    int enlargementOf(const ToolView& view, int tool);
    void drawEnlarged(PartDrawing& drawing, int tool, double scale, double rotation);
    const Mat& matched(const Rect& region, int enlargement);
    void setMatcherImage(const Rect& region, int enlargement);
    const Mat& mask(int enlargement);
    const std::vector<PartTemplate>& templatesFor(const PartDrawing& drawing);
    Rect place(const PartDrawing& drawing, const PartWindows& windows, std::vector<Rect>& placed);

    Size imageSize_;
    int reduction_;
    CameraModel camera_, cameraOfSmall_;   // cameraOfSmall_: of the image at twice its size
    CameraModel partCamera_;               // of a part of that
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
    Mat masks_[2];           // of what is matched, as it is and enlarged
    int painted_[2] = {-1, -1};        // VisibleRegion::changes() then
    Rect wanted_;            // what prepare() asked for
    Rect prepared_;          // where the matcher has it, of the image enlarged so much:
    int preparedEnlargement_;
    Mat enlarged_;           // the (reduced) image at twice its size: up to date where it was asked for
    std::vector<uchar> small_;         // a tool: it is
    struct { VisibleRegion visible; ImageSamples samples; std::vector<uchar> small; } before_;   // the last setImage()
    TemplateCopies copies_;
    std::vector<Rect> windows_;        // in the enlarged image
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
    drawing.enlargement = enlargementOf(drawing.views[tool], tool);
    if (drawing.enlargement > 1) drawEnlarged(drawing, tool, scale, rotation);
}

// The middle of the keypoints, and how far they are from it.
static void surround(const ToolModel& model, const ToolView& view, Point3d& centre, double& radius)
{
    const std::vector<ToolModel::Keypoint>& keypoints = model.keypoints();
    centre = Point3d();
    for (size_t i = 0; i < keypoints.size(); i++)
        centre += transform(view.camera_T_base * view.base_T_link[keypoints[i].link], keypoints[i].linkPoint) / double(keypoints.size());
    radius = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
        radius = std::max(radius, norm(transform(view.camera_T_base * view.base_T_link[keypoints[i].link], keypoints[i].linkPoint) - centre));
}

// By how much an image must be larger for a tool.
int PartFinderImpl::enlargementOf(const ToolView& view, int tool)
{
    if (size_t(tool) >= small_.size()) small_.resize(tool + 1, 0);
    Point3d centre;
    double radius;
    surround(*templates_->model(tool), view, centre, radius);
    const double width = centre.z > nearestDepth ? wristWidth * std::min(camera_.fx, camera_.fy) / centre.z : DBL_MAX;
    small_[tool] = width < (small_[tool] ? largeWrist : smallWrist);
    return small_[tool] ? 2 : 1;
}

// The templates once more, cut from a drawing of the parts' surroundings alone: by a camera that shows no more of the enlarged image.
void PartFinderImpl::drawEnlarged(PartDrawing& drawing, int tool, double scale, double rotation)
{
    const CameraModel& large = cameraOfSmall_;
    Point3d centre;
    double radius;
    surround(*templates_->model(tool), drawing.views[tool], centre, radius);
    const double half = scale * (radius + partsMargin) * std::max(large.fx, large.fy) / std::max(centre.z - radius, nearestDepth);
    const Size all = large.imageSize();
    const int side = int(alignSize(size_t(std::min(2 * half, double(std::max(all.width, all.height)))), 64));
    const Size size(std::min(side, all.width), std::min(side, all.height)), had = partCamera_.imageSize();
    if (size.width > had.width || size.height > had.height)   // takes memory, so it only grows
        partCamera_ = CameraModel(large.cameraMatrix(), large.distCoeffs(), Size(std::max(size.width, had.width), std::max(size.height, had.height)));
    const Size part = partCamera_.imageSize();
    const Point2d at = large.project(centre);
    const Point corner(std::min(std::max(cvRound(at.x) - part.width / 2, 0), all.width - part.width),
                       std::min(std::max(cvRound(at.y) - part.height / 2, 0), all.height - part.height));
    partCamera_.cx = large.cx - corner.x;
    partCamera_.cy = large.cy - corner.y;
    templates_->render(partCamera_, drawing.views, tool, drawing.templates, scale, rotation);
    for (size_t i = 0; i < drawing.templates.size(); i++)
    {
        PartTemplate& t = drawing.templates[i];
        t.imagePoint = enlarged(t.imagePoint + Point2d(corner), 0.5);
        t.anchor = Point(cvRound(t.imagePoint.x), cvRound(t.imagePoint.y));
    }
}

void PartFinderImpl::setImage(const Mat& image)
{
    checkImage(image);
    CV_Assert(image.size() == imageSize_ && "image: of the camera's size");
    before_.visible = visible_;
    before_.samples = samples_;
    before_.small = small_;
    image_ = image;
    interlaced_ = cv::surgtrack::isInterlaced(image);
    if (interlaced_)
    {
        splitFields(image, true, field_, noArray());
        image_ = field_;
    }
    visible_.look(image_);
    samples_.look(image_, reduction_);
    wanted_ = prepared_ = Rect();
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

// The image for matching, up to date in a region of it.
const Mat& PartFinderImpl::matched(const Rect& region, int enlargement)
{
    if (enlargement == 1) return pixels(region);
    const Size size = cameraOfSmall_.imageSize();
    if (reduction_ == 2 && image_.size() == size) return image_;
    const Rect reach(region.x - gradientReach, region.y - gradientReach, region.width + 2 * gradientReach, region.height + 2 * gradientReach);
    const Rect area = reach & Rect(Point(), size);
    const Rect source(area.x / 2, area.y / 2, area.width / 2 + 1, area.height / 2 + 1);
    enlarged_.create(size, image_.type());
    enlargeTwice(pixels(source), area, enlarged_);
    return enlarged_;
}

void PartFinderImpl::prepare(const Rect& region)
{
    const Rect all(Point(), camera_.imageSize());
    wanted_ = region.empty() ? all : region & all;
    setMatcherImage(wanted_, 1);
}

void PartFinderImpl::setMatcherImage(const Rect& region, int enlargement)
{
    prepared_ = region;
    preparedEnlargement_ = enlargement;
    if (visible_.isPartial()) matcher_->setImage(matched(region, enlargement), region, mask(enlargement));
    else matcher_->setImage(matched(region, enlargement), region);
}

const Mat& PartFinderImpl::mask(int enlargement)
{
    Mat& mask = masks_[enlargement - 1];
    if (painted_[enlargement - 1] == visible_.changes()) return mask;
    painted_[enlargement - 1] = visible_.changes();
    mask.create((enlargement == 1 ? camera_ : cameraOfSmall_).imageSize(), CV_8UC1);
    visible_.paint(mask, double(reduction_) / enlargement);
    return mask;
}

void PartFinderImpl::setMask(const Mat& mask)
{
    if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != imageSize_))
        CV_Error(Error::StsBadArg, format("mask must be CV_8UC1 of %d x %d, is %s of %d x %d", imageSize_.width, imageSize_.height,
                                          typeToString(mask.type()).c_str(), mask.cols, mask.rows));
    visible_.setMask(mask);
}

/* As the matcher takes them: in pixels of the image that is matched, and without features where nothing can be seen, as far as it is
   known where the part is: they tell nothing. Copies of those that are to be changed, if there are any. */
const std::vector<PartTemplate>& PartFinderImpl::templatesFor(const PartDrawing& drawing)
{
    const std::vector<PartTemplate>& templates = drawing.templates;
    const int n = drawing.enlargement;
    const double back = double(reduction_) / n;   // to pixels of the images given
    bool changed = n > 1;
    for (size_t i = 0; i < templates.size() && visible_.isPartial() && !changed; i++)
    {
        const Rect& b = templates[i].bounds;
        const Point2d at = expected_[i] - templates[i].imagePoint + Point2d(templates[i].anchor);
        const Point2d low = enlarged(at + Point2d(b.tl()), back), high = enlarged(at + Point2d(b.br()), back);
        changed = !visible_.seesAll(Rect2d(low, high));
    }
    if (!changed) return templates;
    std::vector<PartTemplate>& copies = copies_.of(templates);
    for (size_t i = 0; i < copies.size(); i++)
    {
        PartTemplate& t = copies[i];
        Point2d expected = expected_[i];
        if (n > 1)
        {
            expected = enlarged(expected, n);
            t.imagePoint = enlarged(t.imagePoint, n);
            t.anchor = Point(cvRound(t.imagePoint.x), cvRound(t.imagePoint.y));
        }
        if (!visible_.isPartial()) continue;
        const Point2d shift = expected - t.imagePoint + Point2d(t.anchor);
        size_t kept = 0;
        for (size_t k = 0; k < t.features.size(); k++)
            if (visible_.sees(enlarged(shift + Point2d(t.features[k].x, t.features[k].y), back))) t.features[kept++] = t.features[k];
        if (2 * kept < t.features.size()) kept = 0;   // the rest is not what was chosen to tell the part
        t.features.resize(kept);
    }
    return copies;
}

// The windows, and what of the image that is matched they and the templates in them cover.
Rect PartFinderImpl::place(const PartDrawing& drawing, const PartWindows& windows, std::vector<Rect>& placed)
{
    const Rect all(Point(), camera_.imageSize()), allMatched = enlarged(all, drawing.enlargement);
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
        const Rect w = enlarged(placed.back(), drawing.enlargement);
        if (w.empty()) continue;
        const Rect reach = Rect(w.x + t.bounds.x, w.y + t.bounds.y, w.width + t.bounds.width, w.height + t.bounds.height) & allMatched;
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
    // What a find() before prepared does not count: nothing depends on what was looked for before.
    const int n = drawing.enlargement;
    const Rect wanted = enlarged(wanted_, n), region = (roi & wanted) == roi ? wanted : roi;
    if (region != wanted || prepared_ != wanted || preparedEnlargement_ != n) setMatcherImage(region, n);
    found.imageTime = lap();
    const std::vector<PartTemplate>& templates = templatesFor(drawing);
    for (size_t i = 0; i < templates.size(); i++)
        if (templates[i].features.empty()) found.windows[i] = Rect();
    windows_.resize(found.windows.size());
    for (size_t i = 0; i < windows_.size(); i++) windows_[i] = enlarged(found.windows[i], n);
    matcher_->match(templates, windows_, found.matches);
    for (size_t i = 0; i < found.matches.size(); i++)
    {
        PartMatch& m = found.matches[i];
        if (n > 1) m.imagePoint = enlarged(m.imagePoint, 1. / n);
        m.predictedPoint = expected_[m.templateIndex];
    }
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

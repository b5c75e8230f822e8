// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Pictures of what each stage of the tracker sees in a frame: the public stages, run once more from the tracker's estimates.

#ifndef OPENCV_SURGTRACK_SAMPLES_DEBUG_PICTURES_HPP
#define OPENCV_SURGTRACK_SAMPLES_DEBUG_PICTURES_HPP

#include <set>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/imgcodecs.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack.hpp"
#include "common.hpp"

namespace common {

using namespace cv;
using namespace cv::surgtrack;

//! One tool in one frame.
struct DebugTool
{
    String name;
    Ptr<ToolModel> model;
    Matx44d expected_camera_T_base, found_camera_T_base;   // before and after the frame
    std::vector<double> expectedJoints, foundJoints;       // readings and the offsets known then
    bool known;                                            // whether it was followed before
};

//! Which frames are wanted: `3,17,40`, or `every:25` from the first one on.
class FrameChoice
{
public:
    FrameChoice(const String& text, int first) : text_(text), first_(first), every_(0), seen_(false)
    {
        const std::string s = text;
        if (s.compare(0, 6, "every:") == 0)
            every_ = number(s.substr(6), 1);
        else
            for (size_t at = 0, comma; at <= s.size(); at = comma + 1)
            {
                comma = std::min(s.find(',', at), s.size());
                frames_.insert(number(s.substr(at, comma - at), 0));
            }
    }

    bool wants(int frame)
    {
        const bool wanted = every_ ? (frame - first_) % every_ == 0 : frames_.count(frame) > 0;
        seen_ = seen_ || wanted;
        return wanted;
    }

    //! At the end: throws if there was none.
    void check() const
    {
        if (!seen_)
            fail("argument '--debug-frames=" + text_ + "': none of these frames was tracked");
    }

private:
    int number(const std::string& word, int least) const
    {
        char* end = 0;
        errno = 0;
        const long value = std::strtol(word.c_str(), &end, 10);
        if (end == word.c_str() || *end || errno || value < least || value > INT_MAX)
            fail("argument '--debug-frames=" + text_ + "': expected numbers of frames, as in 3,17,40, or every:N");
        return (int)value;
    }

    String text_;
    int first_, every_;
    std::set<int> frames_;
    bool seen_;
};

class DebugPictures
{
public:
    /** @param folder is made if need be
    @param camera of the images
    @param method of the tracker, see TrackingMethod */
    DebugPictures(const String& folder, const CameraModel& camera, int method)
        : folder_(folder), reduction_(std::max(1, camera.imageSize().width / 720)), scale_(camera.imageSize().width / reduction_ / 720.)
    {
        if (!utils::fs::createDirectories(folder))
            fail(folder + ": is not a folder and can't be made one");
        camera_ = part(camera, Rect(0, 0, camera.imageSize().width / reduction_ * reduction_, camera.imageSize().height / reduction_ * reduction_), 1. / reduction_);
        context_.zoneRadius *= scale_;
        if (method != METHOD_FULL)   // as the tracker does
        {
            context_.centredZones = false;
            context_.maxScale = context_.maxRotation = 0;
        }
        drawing_.wholeTool = true;
        matcher_ = QGOMatcher::create();
        renderer_ = MeshRenderer::createSoftware();
    }

    /** @brief Writes the pictures of a frame: FRAME_TOOL_STAGE.png, and all of them in FRAME_TOOL.jpg. */
    void write(int frame, const Mat& image, const std::vector<DebugTool>& tools)
    {
        if (!templates_)
        {
            templates_ = PartTemplateRenderer::create(renderer_, drawing_);
            for (size_t i = 0; i < tools.size(); i++)
                templates_->addTool(tools[i].model);
        }
        resize(image, image_, camera_.imageSize(), 0, 0, INTER_AREA);
        for (int i = 0; i < (int)tools.size(); i++)
        {
            prefix_ = format("%s/%06d_%s", folder_.c_str(), frame, tools[i].name.c_str());
            title_ = format("frame %d, %s", frame, tools[i].name.c_str());
            if (look(tools, i))
                writeStages(tools, i);
        }
    }

private:
    enum { WIDTH = 720 };   // of a picture, about

    //! What a part of the image, so much larger or smaller, is the image of.
    static CameraModel part(const CameraModel& camera, const Rect& crop, double zoom)
    {
        const Matx33d K(camera.fx * zoom, 0, (camera.cx - crop.x + 0.5) * zoom - 0.5, 0, camera.fy * zoom, (camera.cy - crop.y + 0.5) * zoom - 0.5, 0, 0, 1);
        return CameraModel(K, camera.distCoeffs(), Size(cvRound(crop.width * zoom), cvRound(crop.height * zoom)));
    }

    Point2d zoomed(const Point2d& p) const { return Point2d((p.x - crop_.x + 0.5) * zoom_ - 0.5, (p.y - crop_.y + 0.5) * zoom_ - 0.5); }

    std::vector<PartMatch> zoomed(std::vector<PartMatch> matches) const
    {
        for (size_t i = 0; i < matches.size(); i++)
        {
            matches[i].imagePoint = zoomed(matches[i].imagePoint);
            matches[i].predictedPoint = zoomed(matches[i].predictedPoint);
        }
        return matches;
    }

    Mat zoomed(const Mat& image, int interpolation) const
    {
        Mat result;
        resize(image(crop_), result, Size(), zoom_, zoom_, interpolation);
        return result;
    }

    //! Light for text on any background.
    static void write(Mat& picture, const String& text, Point at, double size = 0.5, const Scalar& color = Scalar::all(255))
    {
        putText(picture, text, at, FONT_HERSHEY_SIMPLEX, size, Scalar::all(0), 3, LINE_AA);
        putText(picture, text, at, FONT_HERSHEY_SIMPLEX, size, color, 1, LINE_AA);
    }

    static Mat beside(const Mat& left, const Mat& right)
    {
        Mat result, gap(left.rows, 6, CV_8UC3, Scalar::all(255));
        hconcat(std::vector<Mat>({left, gap, right}), result);
        return result;
    }

    //! The stages up to the inliers. Returns whether there is a part to look at.
    bool look(const std::vector<DebugTool>& tools, int index)
    {
        const DebugTool& tool = tools[index];
        std::vector<ToolView> views(tools.size());
        for (size_t i = 0; i < tools.size(); i++)
        {
            views[i].camera_T_base = tools[i].expected_camera_T_base;
            tools[i].model->forwardKinematics(tools[i].expectedJoints, views[i].base_T_link);
        }
        templates_->render(camera_, views, index, parts_);
        if (parts_.empty())
            return false;
        const ToolTracker::Params tracker;
        windows_.clear();
        Rect box;
        for (size_t i = 0; i < parts_.size(); i++)
        {
            const PartTemplate& t = parts_[i];
            const int half = cvRound(tool.known ? tracker.minWindow * scale_ : tracker.initialWindow * std::max(camera_.fx, camera_.fy) / t.viewPoint.z);
            windows_.push_back(Rect(t.anchor.x - half, t.anchor.y - half, 2 * half + 1, 2 * half + 1) & Rect(Point(), camera_.imageSize()));
            box = box.empty() ? windows_[i] : box | windows_[i];
        }
        matcher_->setImage(image_);
        matcher_->match(parts_, windows_, matches_);
        const Ptr<GeometricContextVerifier> verifier = GeometricContextVerifier::create(context_);
        verifier->verify(matches_, inliers_);
        sample_ = verifier->sample();

        // The parts' surroundings, of the image's shape, so that all pictures are of one size.
        const Size all = camera_.imageSize();
        const double share = std::min(1., std::max(double(box.width) / all.width, double(box.height) / all.height));
        const Size size(std::max(8, cvFloor(share * all.width)), std::max(8, cvFloor(share * all.height)));
        const Point at(box.x + box.width / 2 - size.width / 2, box.y + box.height / 2 - size.height / 2);
        crop_ = Rect(Point(std::min(std::max(at.x, 0), all.width - size.width), std::min(std::max(at.y, 0), all.height - size.height)), size);
        zoom_ = std::max(1, cvRound(double(WIDTH) / size.width));
        view_ = part(camera_, crop_, zoom_);
        return true;
    }

    std::vector<DrawnTool> drawn(const std::vector<DebugTool>& tools, bool found, const Scalar& color, double opacity) const
    {
        std::vector<DrawnTool> result;
        for (size_t i = 0; i < tools.size(); i++)
            result.push_back(DrawnTool(tools[i].model, found ? tools[i].foundJoints : tools[i].expectedJoints,
                                       found ? tools[i].found_camera_T_base : tools[i].expected_camera_T_base, color, opacity));
        return result;
    }

    void writeStages(const std::vector<DebugTool>& tools, int index)
    {
        std::vector<Mat> pictures;
        pictures.push_back(save("1_view", drawView(tools, index)));
        pictures.push_back(save("2_orientations", drawBothOrientations(tools)));
        pictures.push_back(save("3_templates", drawTemplates(tools, index)));
        pictures.push_back(save("4_similarity", drawSimilarities(tools[index])));
        pictures.push_back(save("5_context", drawContext(tools)));
        pictures.push_back(save("6_contour", drawResiduals(tools, index)));
        // The sheet: three rows of two, the same height in a row.
        std::vector<Mat> rows;
        for (size_t i = 0; i < pictures.size(); i += 2)
        {
            Mat left = pictures[i], right = pictures[i + 1], row;
            const double ratio = double(left.cols) / left.rows + double(right.cols) / right.rows;
            const int height = cvRound(2 * WIDTH / ratio);
            const int width = cvRound(height * double(left.cols) / left.rows);
            resize(left, left, Size(width, height), 0, 0, INTER_AREA);
            resize(right, right, Size(2 * WIDTH - width, height), 0, 0, INTER_AREA);
            hconcat(left, right, row);
            rows.push_back(row);
        }
        Mat sheet;
        vconcat(rows, sheet);
        if (!imwrite(prefix_ + ".jpg", sheet))
            fail(prefix_ + ".jpg: can't be written");
    }

    Mat save(const String& stage, const Mat& picture) const
    {
        const String filename = prefix_ + "_" + stage + ".png";
        if (!imwrite(filename, picture))
            fail(filename + ": can't be written");
        return picture;
    }

    //! Paper, Fig. 1c: the tools as they are expected, with the keypoints; those with a template are filled.
    Mat drawView(const std::vector<DebugTool>& tools, int index) const
    {
        Mat picture(view_.imageSize(), CV_8UC3, Scalar::all(80));
        drawTools(picture, view_, drawn(tools, false, Scalar::all(255), 1), renderer_, 0);
        const DebugTool& tool = tools[index];
        Mat basePoints;
        tool.model->keypointPositions(tool.expectedJoints, basePoints);
        const std::vector<String> names = tool.model->keypointNames();
        for (int i = 0; i < basePoints.rows; i++)
        {
            const Vec4d p = tool.expected_camera_T_base * Vec4d(basePoints.at<double>(i, 0), basePoints.at<double>(i, 1), basePoints.at<double>(i, 2), 1);
            if (p[2] < 1e-3)
                continue;
            const Point2d u = view_.project(Point3d(p[0], p[1], p[2]));
            if (!Rect(Point(), picture.size()).contains(Point(u)))
                continue;
            bool visible = false;
            for (size_t k = 0; k < parts_.size(); k++)
                visible = visible || parts_[k].part == i;
            circle(picture, u, 6, Scalar::all(0), visible ? (int)FILLED : 3, LINE_AA);
            circle(picture, u, visible ? 5 : 6, partColor(i), visible ? (int)FILLED : 1, LINE_AA);
            if (visible)
                write(picture, names[i], Point(u) + Point(8, 4), 0.4);
        }
        write(picture, title_ + ": drawn as expected; filled: parts with a template", Point(8, 18));
        return picture;
    }

    //! Paper, Fig. 2b: of the drawing and of the image.
    Mat drawBothOrientations(const std::vector<DebugTool>& tools) const
    {
        Mat pictures[2];
        for (int i = 0; i < 2; i++)
        {
            Mat source = image_.clone(), orientations;
            if (i == 0)
            {
                source.setTo(Scalar::all(80));
                drawTools(source, camera_, drawn(tools, false, Scalar::all(255), 1), renderer_, 0);
            }
            quantizeOrientations(source, orientations, i == 0 ? drawing_.magnitudeThreshold : QGOMatcher::Params().magnitudeThreshold);
            pictures[i] = zoomed(source, INTER_LINEAR) * 0.5;
            drawOrientations(pictures[i], zoomed(orientations, INTER_NEAREST));
            write(pictures[i], i == 0 ? title_ + ": orientations of the drawing" : "orientations of the image", Point(8, 18));
        }
        drawOrientationLegend(pictures[0], freeCorner(tools), pictures[0].rows / 9);
        return beside(pictures[0], pictures[1]);
    }

    //! Where a legend hides least of the tools.
    Point freeCorner(const std::vector<DebugTool>& tools) const
    {
        Mat covered = Mat::zeros(view_.imageSize(), CV_8UC3), grey;
        drawTools(covered, view_, drawn(tools, false, Scalar::all(255), 1), renderer_, 0);
        cvtColor(covered, grey, COLOR_BGR2GRAY);
        const int side = 3 * (grey.rows / 9), right = grey.cols - side, bottom = grey.rows - side;
        const Point corners[] = { Point(right, bottom), Point(0, bottom), Point(right, side / 6), Point(0, side / 6) };   // below the title
        int best = 0;
        for (int i = 1; i < 4; i++)
            if (countNonZero(grey(Rect(corners[i], Size(side, side)))) < countNonZero(grey(Rect(corners[best], Size(side, side)))))
                best = i;
        return corners[best] + Point(side / 2, side / 2);
    }

    //! Tiles of one size in rows.
    static Mat tile(const std::vector<Mat>& tiles, const String& title)
    {
        const int gap = 6, columns = std::max(3, cvCeil(std::sqrt(2 * double(tiles.size())))), rows = ((int)tiles.size() + columns - 1) / columns;
        const Size size(tiles[0].cols + gap, tiles[0].rows + gap);
        Mat result(30 + rows * size.height, std::max(columns * size.width + gap, (int)WIDTH), CV_8UC3, Scalar::all(40));
        for (int i = 0; i < (int)tiles.size(); i++)
            tiles[i].copyTo(result(Rect(gap + i % columns * size.width, 30 + i / columns * size.height, tiles[i].cols, tiles[i].rows)));
        write(result, title, Point(8, 20));
        return result;
    }

    enum { TILE = 220 };   // [pixel]

    //! Paper, Fig. 2a: each part's features on the drawing.
    Mat drawTemplates(const std::vector<DebugTool>& tools, int index) const
    {
        Mat drawing(camera_.imageSize(), CV_8UC3, Scalar::all(80));
        drawTools(drawing, camera_, drawn(tools, false, Scalar::all(255), 1), renderer_, 0);
        const std::vector<String> names = tools[index].model->keypointNames();
        int reach = 1;
        for (size_t i = 0; i < parts_.size(); i++)
        {
            const Rect& b = parts_[i].bounds;
            reach = std::max(reach, std::max(std::max(-b.x, -b.y), std::max(b.x + b.width, b.y + b.height)) + 2);
        }
        const int pixel = std::max(2, TILE / (2 * reach + 1));
        std::vector<Mat> tiles;
        for (size_t i = 0; i < parts_.size(); i++)
        {
            Mat padded, picture;
            copyMakeBorder(drawing * 0.6, padded, reach, reach, reach, reach, BORDER_CONSTANT, Scalar::all(0));
            resize(padded(Rect(parts_[i].anchor.x, parts_[i].anchor.y, 2 * reach + 1, 2 * reach + 1)), picture, Size(), pixel, pixel, INTER_NEAREST);
            const Point middle(picture.cols / 2, picture.rows / 2);
            drawTemplate(picture, parts_[i], middle, pixel);
            drawMarker(picture, middle, Scalar::all(0), MARKER_CROSS, 17, 5);
            drawMarker(picture, middle, Scalar::all(255), MARKER_CROSS, 15, 2);
            write(picture, format("%s: %d", names[parts_[i].part].c_str(), (int)parts_[i].features.size()), Point(5, picture.rows - 7), 0.4);
            tiles.push_back(picture);
        }
        return tile(tiles, title_ + ": templates, features by orientation");
    }

    //! Paper, Fig. 2c: each part's similarity over its window, its candidates, and the one that agrees with the others.
    Mat drawSimilarities(const DebugTool& tool) const
    {
        const std::vector<String> names = tool.model->keypointNames();
        std::vector<Mat> tiles;
        for (size_t i = 0; i < parts_.size(); i++)
        {
            const Rect& window = windows_[i];
            Mat similarity, picture, square = Mat::zeros(TILE, TILE, CV_8UC3);
            if (!window.empty())
            {
                matcher_->similarityMap(parts_[i], window, similarity);
                drawSimilarity(similarity, parts_[i], picture);
                const double zoom = double(TILE) / std::max(window.width, window.height);
                resize(picture, picture, Size(std::max(1, cvFloor(window.width * zoom)), std::max(1, cvFloor(window.height * zoom))), 0, 0, INTER_CUBIC);
                picture.copyTo(square(Rect(Point(), picture.size())));
                for (int pass = 0; pass < 2; pass++)
                {
                    const std::vector<PartMatch>& matches = pass ? inliers_ : matches_;
                    for (size_t k = 0; k < matches.size(); k++)
                        if (matches[k].part == parts_[i].part)
                            circle(square, (matches[k].imagePoint - Point2d(window.tl())) * zoom, pass ? 5 : 7, pass ? Scalar(0, 255, 0) : Scalar::all(255),
                                   pass ? (int)FILLED : 1, LINE_AA);
                }
            }
            double best = 0;
            if (!similarity.empty())
                minMaxLoc(similarity, 0, &best);
            write(square, format("%s: %.2f", names[parts_[i].part].c_str(), best / (4. * double(parts_[i].features.size()))), Point(5, square.rows - 7), 0.4);
            tiles.push_back(square);
        }
        return tile(tiles, title_ + ": similarity, candidates, inliers (green)");
    }

    //! Paper, Fig. 2d-f.
    Mat drawContext(const std::vector<DebugTool>& tools) const
    {
        Mat drawing(view_.imageSize(), CV_8UC3, Scalar::all(80)), seen = zoomed(image_, INTER_CUBIC) * 0.7;
        drawTools(drawing, view_, drawn(tools, false, Scalar::all(200), 1), renderer_, 0);
        GeometricContextVerifier::Params params = context_;
        params.zoneRadius *= zoom_;
        const std::vector<PartMatch> matches = zoomed(matches_), inliers = zoomed(inliers_), sample = zoomed(sample_);
        drawGeometricContext(drawing, matches, inliers, sample, true, params);
        drawGeometricContext(seen, matches, inliers, sample, false, params);
        write(drawing, title_ + ": grid of the drawing", Point(8, 18));
        write(seen, format("grid of the image: %d of %d candidates agree", (int)inliers_.size(), (int)matches_.size()), Point(8, 18));
        return beside(drawing, seen);
    }

    //! Where the outline of the final pose has its edges.
    Mat drawResiduals(const std::vector<DebugTool>& tools, int index)
    {
        std::vector<ToolView> views(tools.size());
        for (size_t i = 0; i < tools.size(); i++)
        {
            views[i].camera_T_base = tools[i].found_camera_T_base;
            tools[i].model->forwardKinematics(tools[i].foundJoints, views[i].base_T_link);
        }
        std::vector<PartTemplate> parts;
        templates_->render(camera_, views, index, parts);
        std::vector<ContourPoint> points;
        ToolContour::create(tools[index].model)->sample(camera_, views[index], templates_->rendering(), index + 1, points);
        ContourSearch search;   // that of ToolEstimate::contourSupport
        search.halfWindow = std::min(40., std::max(2., 6 * scale_));
        search.preference = 0;
        search.ambiguity = 1;
        matchContour(image_, points, search);
        const double within = 1.5 * scale_;
        int supported = 0;
        for (size_t i = 0; i < points.size(); i++)
        {
            supported += points[i].found && std::abs(points[i].offset) < within;
            points[i].imagePoint = zoomed(points[i].imagePoint);
        }
        Mat picture = zoomed(image_, INTER_CUBIC) * 0.8;
        drawTools(picture, view_, drawn(tools, true, Scalar(0, 255, 0), 0), renderer_, 1);
        drawContour(picture, points, 2 * within, zoom_);
        write(picture, title_ + format(": outline as found, %d of %d points on an edge", supported, (int)points.size()), Point(8, 18));
        return picture;
    }

    String folder_, prefix_, title_;
    int reduction_;       // of the images, as in the tracker
    double scale_;        // of thresholds given for images 720 pixels wide
    CameraModel camera_;  // of the reduced image
    GeometricContextVerifier::Params context_;
    PartTemplateRenderer::Params drawing_;
    Ptr<MeshRenderer> renderer_;
    Ptr<PartTemplateRenderer> templates_;
    Ptr<QGOMatcher> matcher_;

    // of one tool in one frame
    Mat image_;
    std::vector<PartTemplate> parts_;
    std::vector<Rect> windows_;
    std::vector<PartMatch> matches_, inliers_, sample_;
    Rect crop_;           // what the pictures show,
    int zoom_;            // so much larger
    CameraModel view_;    // of the pictures
};

} // namespace common

#endif

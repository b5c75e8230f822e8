// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Pictures of what each stage of the tracker sees in a frame.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_DEBUG_PICTURES_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_DEBUG_PICTURES_HPP

#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/imgcodecs.hpp"
#include "opencv2/imgproc.hpp"
#include "common.hpp"
#include "debug_stages.hpp"

namespace common {

class DebugPictures : private DebugStages
{
public:
    /** @param folder is made if need be
    @param camera of the images
    @param method of the tracker, see TrackingMethod */
    DebugPictures(const String& folder, const CameraModel& camera, int method) : DebugStages(camera, method), folder_(folder)
    {
        if (!utils::fs::createDirectories(folder))
            fail(folder + ": is not a folder and can't be made one");
    }

    /** @brief Writes the pictures of a frame: FRAME_TOOL_STAGE.png, and all of them in FRAME_TOOL.jpg. */
    void write(int frame, const Mat& image, const std::vector<DebugTool>& tools)
    {
        setImage(image, tools);
        for (int i = 0; i < (int)tools.size(); i++)
        {
            prefix_ = format("%s/%06d_%s", folder_.c_str(), frame, tools[i].name.c_str());
            title_ = format("frame %d, %s", frame, tools[i].name.c_str());
            if (look(tools, i))
                writeStages(tools, i);
        }
    }

private:
    //! Light for text on any background.
    static void label(Mat& picture, const String& text, Point at, double size = 0.5, const Scalar& color = Scalar::all(255))
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
                label(picture, names[i], Point(u) + Point(8, 4), 0.4);
        }
        label(picture, title_ + ": drawn as expected; filled: parts with a template", Point(8, 18));
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
            label(pictures[i], i == 0 ? title_ + ": orientations of the drawing" : "orientations of the image", Point(8, 18));
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
        label(result, title, Point(8, 20));
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
            label(picture, format("%s: %d", names[parts_[i].part].c_str(), (int)parts_[i].features.size()), Point(5, picture.rows - 7), 0.4);
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
            label(square, format("%s: %.2f", names[parts_[i].part].c_str(), best / (4. * double(parts_[i].features.size()))), Point(5, square.rows - 7), 0.4);
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
        label(drawing, title_ + ": grid of the drawing", Point(8, 18));
        label(seen, format("grid of the image: %d of %d candidates agree", (int)inliers_.size(), (int)matches_.size()), Point(8, 18));
        return beside(drawing, seen);
    }

    //! Where the outline of the final pose has its edges.
    Mat drawResiduals(const std::vector<DebugTool>& tools, int index)
    {
        std::vector<ContourPoint> points;
        const int supported = findOutline(tools, index, points);
        Mat picture = zoomed(image_, INTER_CUBIC) * 0.8;
        drawTools(picture, view_, drawn(tools, true, Scalar(0, 255, 0), 0), renderer_, 1);
        drawContour(picture, points, 3 * scale_, zoom_);
        label(picture, title_ + format(": outline as found, %d of %d points on an edge", supported, (int)points.size()), Point(8, 18));
        return picture;
    }

    String folder_, prefix_, title_;
};

} // namespace common

#endif

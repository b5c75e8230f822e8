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
    @param method of the tracker, see TrackingMethod */
    DebugPictures(const String& folder, int method) : DebugStages(method), folder_(folder)
    {
        if (!utils::fs::createDirectories(folder))
            fail(folder + ": is not a folder and can't be made one");
    }

    /** @brief Writes the pictures of a frame: FRAME_TOOL_STAGE.png, and all of them in FRAME_TOOL.jpg. */
    void write(int frame, const Mat& image, const std::vector<DebugTool>& tools)
    {
        for (int i = 0; i < (int)tools.size(); i++)
        {
            prefix_ = format("%s/%06d_%s", folder_.c_str(), frame, tools[i].name.c_str());
            title_ = format("frame %d, %s", frame, tools[i].name.c_str());
            if (look(image, tools[i]))
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

    void writeStages(const std::vector<DebugTool>& tools, int index)
    {
        std::vector<Mat> pictures;
        pictures.push_back(save("1_view", drawView(tools[index])));
        pictures.push_back(save("2_orientations", drawBothOrientations()));
        pictures.push_back(save("3_templates", drawTemplates(tools[index])));
        pictures.push_back(save("4_similarity", drawSimilarities(tools[index])));
        pictures.push_back(save("5_context", drawContext()));
        pictures.push_back(save("6_contour", drawResiduals(tools)));
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

    //! Paper, Fig. 1c: the tools as they were drawn, with the keypoints; those with a template are filled.
    Mat drawView(const DebugTool& tool) const
    {
        Mat picture = zoomed(lit(), INTER_CUBIC);
        const ToolView& view = sight_.views[sight_.templates[0].tool];
        const std::vector<ToolModel::Keypoint>& keypoints = tool.model->keypoints();
        for (int i = 0; i < (int)keypoints.size(); i++)
        {
            const Point3d& k = keypoints[i].linkPoint;
            const Vec4d p = view.camera_T_base * (view.base_T_link[keypoints[i].link] * Vec4d(k.x, k.y, k.z, 1));
            if (p[2] < 1e-3)
                continue;
            const PartTemplate* visible = 0;
            for (size_t j = 0; j < sight_.templates.size(); j++)
                if (sight_.templates[j].part == i)
                    visible = &sight_.templates[j];
            const Point2d u = visible ? zoomed(visible->imagePoint) : view_.project(Point3d(p[0], p[1], p[2]));   // a template may be of another scale
            if (!Rect(Point(), picture.size()).contains(Point(u)))
                continue;
            circle(picture, u, 6, Scalar::all(0), visible ? (int)FILLED : 3, LINE_AA);
            circle(picture, u, visible ? 5 : 6, partColor(i), visible ? (int)FILLED : 1, LINE_AA);
            if (visible)
                label(picture, keypoints[i].name, Point(u) + Point(8, 4), 0.4);
        }
        label(picture, title_ + ": drawn as expected; filled: parts with a template", Point(8, 18));
        return picture;
    }

    //! Paper, Fig. 2b: of the drawing and of the image.
    Mat drawBothOrientations() const
    {
        const ToolTracker::Stages stages;
        Mat pictures[2];
        for (int i = 0; i < 2; i++)
        {
            Mat source = i == 0 ? lit() : image_, orientations;
            if (i == 0)
                quantizeOrientations(source, orientations, stages.templates.magnitudeThreshold);
            else
                matcher_->orientations(orientations);   // of the whole image
            pictures[i] = zoomed(source, INTER_LINEAR) * 0.5;
            drawOrientations(pictures[i], zoomed(orientations, INTER_NEAREST));
            label(pictures[i], i == 0 ? title_ + ": orientations of the drawing" : "orientations of the image", Point(8, 18));
        }
        drawOrientationLegend(pictures[0], freeCorner(), pictures[0].rows / 9);
        return beside(pictures[0], pictures[1]);
    }

    //! Where a legend hides least of the tools.
    Point freeCorner() const
    {
        Mat covered;
        lit(&covered);
        const Mat grey = zoomed(covered, INTER_NEAREST);
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
    Mat drawTemplates(const DebugTool& tool) const
    {
        Mat drawing = lit();
        const int enlargement = sight_.enlargement;
        resize(drawing, drawing, drawing.size() * enlargement, 0, 0, INTER_LINEAR);
        const std::vector<String> names = tool.model->keypointNames();
        int reach = 1;
        for (size_t i = 0; i < sight_.templates.size(); i++)
        {
            const Rect& b = sight_.templates[i].bounds;
            reach = std::max(reach, std::max(std::max(-b.x, -b.y), std::max(b.x + b.width, b.y + b.height)) + 2);
        }
        const int pixel = std::max(2, TILE / (2 * reach + 1));
        std::vector<Mat> tiles;
        for (size_t i = 0; i < sight_.templates.size(); i++)
        {
            Mat padded, picture;
            copyMakeBorder(drawing * 0.6, padded, reach, reach, reach, reach, BORDER_CONSTANT, Scalar::all(0));
            resize(padded(Rect(enlargement * sight_.templates[i].anchor.x, enlargement * sight_.templates[i].anchor.y, 2 * reach + 1, 2 * reach + 1)), picture, Size(), pixel, pixel, INTER_NEAREST);
            const Point middle(picture.cols / 2, picture.rows / 2);
            drawTemplate(picture, sight_.templates[i], middle, pixel);
            drawMarker(picture, middle, Scalar::all(0), MARKER_CROSS, 17, 5);
            drawMarker(picture, middle, Scalar::all(255), MARKER_CROSS, 15, 2);
            label(picture, format("%s: %d", names[sight_.templates[i].part].c_str(), (int)sight_.templates[i].features.size()), Point(5, picture.rows - 7), 0.4);
            tiles.push_back(picture);
        }
        return tile(tiles, title_ + ": templates, features by orientation");
    }

    //! Paper, Fig. 2c: each part's similarity over its window, its candidates, and the one that agrees with the others.
    Mat drawSimilarities(const DebugTool& tool) const
    {
        const std::vector<String> names = tool.model->keypointNames();
        std::vector<Mat> tiles;
        for (size_t i = 0; i < sight_.templates.size(); i++)
        {
            const Rect& window = sight_.found.windows[i];
            Mat similarity, picture, square = Mat::zeros(TILE, TILE, CV_8UC3);
            if (!window.empty())
            {
                const int n = sight_.enlargement;
                matcher_->similarityMap(sight_.templates[i], Rect(n * window.x, n * window.y, n * window.width, n * window.height), similarity);
                drawSimilarity(similarity, sight_.templates[i], picture);
                const double zoom = double(TILE) / std::max(window.width, window.height);
                resize(picture, picture, Size(std::max(1, cvFloor(window.width * zoom)), std::max(1, cvFloor(window.height * zoom))), 0, 0, INTER_CUBIC);
                picture.copyTo(square(Rect(Point(), picture.size())));
                for (int pass = 0; pass < 2; pass++)
                {
                    const std::vector<PartMatch>& matches = pass ? sight_.found.inliers : sight_.found.matches;
                    for (size_t k = 0; k < matches.size(); k++)
                        if (matches[k].part == sight_.templates[i].part)
                            circle(square, (matches[k].imagePoint - Point2d(window.tl())) * zoom, pass ? 5 : 7, pass ? Scalar(0, 255, 0) : Scalar::all(255),
                                   pass ? (int)FILLED : 1, LINE_AA);
                }
            }
            double best = 0;
            if (!similarity.empty())
                minMaxLoc(similarity, 0, &best);
            label(square, format("%s: %.2f", names[sight_.templates[i].part].c_str(), best / (4. * double(sight_.templates[i].features.size()))), Point(5, square.rows - 7), 0.4);
            tiles.push_back(square);
        }
        return tile(tiles, title_ + ": similarity, candidates, inliers (green)");
    }

    //! Paper, Fig. 2d-f.
    Mat drawContext() const
    {
        Mat drawing = zoomed(lit(), INTER_CUBIC) * 0.8, seen = zoomed(image_, INTER_CUBIC) * 0.7;
        GeometricContextVerifier::Params params = context_;
        params.zoneRadius *= zoom_ * scale_;
        const std::vector<PartMatch> matches = zoomed(sight_.found.matches), inliers = zoomed(sight_.found.inliers), sample = zoomed(sight_.found.sample);
        drawGeometricContext(drawing, matches, inliers, sample, true, params);
        drawGeometricContext(seen, matches, inliers, sample, false, params);
        label(drawing, title_ + ": grid of the drawing", Point(8, 18));
        label(seen, format("grid of the image: %d of %d candidates agree", (int)inliers.size(), (int)matches.size()), Point(8, 18));
        return beside(drawing, seen);
    }

    //! Where the outline has its edges: at the pose found, or the last one tried.
    Mat drawResiduals(const std::vector<DebugTool>& tools) const
    {
        Mat picture = zoomed(image_, INTER_CUBIC) * 0.8;
        std::vector<DrawnTool> found;
        for (size_t i = 0; i < tools.size(); i++)
            found.push_back(DrawnTool(tools[i].model, tools[i].foundJoints, tools[i].found_camera_T_base, Scalar(0, 255, 0), 0));
        drawTools(picture, view_, found, renderer_, 1);
        int supported = 0;
        for (size_t i = 0; i < sight_.outline.size(); i++)
            supported += sight_.outline[i].found && std::abs(sight_.outline[i].offset) < 1.5 * scale_;   // as ToolEstimate::contourSupport counts
        drawContour(picture, zoomed(sight_.outline), 3 * scale_, zoom_);
        label(picture, title_ + format(": outline, %d of %d points on an edge", supported, (int)sight_.outline.size()), Point(8, 18));
        return picture;
    }

    String folder_, prefix_, title_;
};

} // namespace common

#endif

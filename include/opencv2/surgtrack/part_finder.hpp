// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_PART_FINDER_HPP
#define OPENCV_SURGTRACK_PART_FINDER_HPP

#include "opencv2/surgtrack/geometric_context.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief The part templates of a tool, and the drawing they were cut from. */
struct CV_EXPORTS PartDrawing
{
    PartDrawing();

    std::vector<ToolView> views;             //!< of all tools, in the frame of the camera they were drawn for; without link poses: not drawn
    std::vector<PartTemplate> templates;     //!< of the tool wanted
    int enlargement;                         //!< features and bounds of the templates are those of an image so many times as large: 1, or 2 of a small tool
    Rendering rendering;                     //!< see PartTemplateRenderer::rendering()
};

/** @brief Where the parts of a tool are looked for: in windows about where they are expected. */
struct CV_EXPORTS PartWindows
{
    explicit PartWindows(double halfWidth = 30);

    double halfWidth;                        //!< of a window, at least [pixel]
    std::vector<Point2d> deviations;         //!< a keypoint: a window is as wide as three of these, if that is more, but not more than 4 halfWidth [pixel]; none: all are halfWidth
    std::vector<Point2d> expected;           //!< a keypoint: the middle of its window [pixel]; none: where the drawing has it
};

/** @brief What PartFinder::find() looked at in one image, and what it found of one tool. */
struct CV_EXPORTS FoundParts
{
    FoundParts();

    std::vector<Rect> windows;               //!< a template; empty: outside of the image
    std::vector<PartMatch> matches;          //!< candidates, by falling similarity
    std::vector<PartMatch> inliers;          //!< of these, those whose arrangement agrees
    std::vector<PartMatch> sample;           //!< GeometricContextVerifier::sample()
    double imageTime, matchTime, verifyTime; //!< what the stages took [s]
};

/** @brief Mean similarity of matches, 0..1; 0 without any. */
CV_EXPORTS double meanSimilarity(const std::vector<PartMatch>& matches);

/** @brief An eye: what a camera is looked at with. Draws part templates, finds them in windows, and verifies their arrangement (paper,
Sec. 2.1 and 2.2). What is found is a value; over time it keeps nothing but memory and which tools are small.

Gradients, and all widths that are given in pixels, are made for images some 720 pixels wide: images of 1440 pixels and more are
reduced by a whole number, and all points are those of the reduced image. Tools that are small in it, with a wrist of less than 30
pixels, are drawn and matched at twice its size, where they have details; points stay those of the reduced image. Not thread-safe. */
class CV_EXPORTS PartFinder
{
public:
    /** @param camera of the images
    @param templates draws and cuts the templates; must know the tools
    @param matcher finds them
    @param eye_T_camera the frame that views are given in, in the frame of this camera; unit: views are in the frame of this one */
    static Ptr<PartFinder> create(const CameraModel& camera, const Ptr<PartTemplateRenderer>& templates,
                                  const Ptr<QGOMatcher>& matcher = QGOMatcher::create(), const Matx44d& eye_T_camera = Matx44d::eye());
    virtual ~PartFinder() {}

    /** @brief Of the images given [pixel]. */
    virtual Size imageSize() const = 0;
    /** @brief By this whole number they are reduced. */
    virtual int reduction() const = 0;
    /** @brief Of the reduced images, which all points are in. */
    virtual const CameraModel& camera() const = 0;
    /** @brief Width of the reduced images / 720: factor of widths that are given for images 720 pixels wide. */
    virtual double pixelScale() const = 0;
    /** @brief See create(). */
    virtual const Matx44d& eye_T_camera() const = 0;
    /** @brief See create(). */
    virtual const Ptr<PartTemplateRenderer>& templates() const = 0;

    /** @brief Draws the tools and cuts the templates of one of them, see PartTemplateRenderer::render().
    @param views of all tools, before eye_T_camera
    @param tool the one wanted
    @param drawing result
    @param scale, rotation see PartTemplateRenderer::render()
    @param alone the others are not drawn, and hide nothing */
    virtual void draw(const std::vector<ToolView>& views, int tool, PartDrawing& drawing, double scale = 1, double rotation = 0,
                      bool alone = false) = 0;

    /** @brief The next image. Of an interlaced one, known by its combs, the first field is looked at. Black surrounds are looked for now
    and then.
    @param image CV_8UC1 or CV_8UC3 of imageSize(); not copied, must stay until release() */
    virtual void setImage(const Mat& image) = 0;
    /** @brief Where there is something to see. @param mask CV_8UC1 of imageSize(), 0 where there is nothing; empty: anywhere. Black
    surrounds need no mask; overlays of a console do */
    virtual void setMask(const Mat& mask) = 0;
    /** @brief Whether the image has two fields of different times. */
    virtual bool isInterlaced() const = 0;
    /** @brief Whether there is something to see at a place. @param p of the reduced image [pixel] */
    virtual bool sees(const Point2d& p) const = 0;
    /** @brief Mean difference from the image before [grey levels]; DBL_MAX without one. @param region of the reduced image */
    virtual double change(const Rect& region) const = 0;
    /** @brief Lets go of the image. */
    virtual void release() = 0;
    /** @brief As if the last setImage() had not been, for change() and what is seen; that image is let go of. */
    virtual void takeBack() = 0;
    /** @brief The reduced image, made where it is asked for. @param region where gradients are needed; empty: where they were asked for before */
    virtual const Mat& pixels(const Rect& region) = 0;

    /** @brief Prepares a region of the image for matching, which find() does by itself for what it needs: worth it where much is looked for
    in one image. @param region of the reduced image; empty: all of it */
    virtual void prepare(const Rect& region = Rect()) = 0;

    /** @brief Matches templates in windows of the image and verifies their arrangement.
    @param drawing whose templates are looked for
    @param windows where
    @param verifier decides which candidates agree
    @param found result */
    virtual void find(const PartDrawing& drawing, const PartWindows& windows, GeometricContextVerifier& verifier, FoundParts& found) = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif

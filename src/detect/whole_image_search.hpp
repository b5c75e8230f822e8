// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_WHOLE_IMAGE_SEARCH_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_WHOLE_IMAGE_SEARCH_HPP

#include "opencv2/surgtrack/qgo_matcher.hpp"
#include "detect/qgo.hpp"

namespace cv { namespace surgtrack {

//! Offsets of a template's features from its keypoint.
Rect reachOf(const PartTemplate& t);

/* Similarities of the places of an image, 4 x 4 at a time, where they are asked for. Cells and their slots are kept from
   template to template, clear() forgets what was found. */
class CellMap
{
public:
    void setImage(const Size& image, const Mat& spread, const Rect& roi)
    {
        clear();
        size_ = image;
        spread_ = spread;
        roi_ = roi;
        cells_ = Size((image.width + 3) / 4, (image.height + 3) / 4);
        if (slots_.size() < size_t(cells_.area())) slots_.resize(cells_.area(), 0);
    }
    void setTemplate(const PartTemplate& t)
    {
        clear();
        template_ = &t;
        features_.resize(t.features.size());
        Point low(SHRT_MAX, SHRT_MAX), high(SHRT_MIN, SHRT_MIN);
        for (size_t i = 0; i < features_.size(); i++)
        {
            const TemplateFeature& f = t.features[i];
            low = Point(std::min(low.x, int(f.x)), std::min(low.y, int(f.y)));
            high = Point(std::max(high.x, int(f.x)), std::max(high.y, int(f.y)));
            features_[i].same = uchar(1 << f.bin);
            features_[i].wide = uchar(1 << f.bin | 1 << ((f.bin + 1) & 7) | 1 << ((f.bin + 7) & 7));
        }
        for (size_t i = 0; i < features_.size(); i++)
            features_[i].offset = int((t.features[i].y - low.y) * (ptrdiff_t)spread_.step) + t.features[i].x - low.x;
        reach_ = Rect(low, high + Point(4, 4));   // of a cell's 4 x 4 places
    }
    void clear()
    {
        for (size_t i = 0; i < found_.size(); i++) slots_[found_[i].cell] = 0;
        found_.clear();
        suppressed_.clear();
    }

    Size cells() const { return cells_; }
    int evaluate(int cell);
    Size size() const { return size_; }
    int operator()(int y, int x)
    {
        const int cell = (y >> 2) * cells_.width + (x >> 2);
        if (!slots_[cell]) evaluate(cell);
        return found_[slots_[cell] - 1].sums[(y & 3) * 4 + (x & 3)];
    }
    bool best(int& similarity, Point& at) const;
    void suppress(const Rect& area);

private:
    struct Found
    {
        int cell, best;
        ushort sums[16];
    };

    Point place(int cell) const { return Point(cell % cells_.width * 4, cell / cells_.width * 4); }
    void zero(Found& found, const Rect& area) const;
    static int most(const Found& found) { return *std::max_element(found.sums, found.sums + 16); }

    Size size_, cells_;
    Mat spread_;
    Rect roi_, reach_;
    const PartTemplate* template_;
    std::vector<CellFeature> features_;
    std::vector<int> slots_;      // of each cell: 1 + its place in found_, or 0
    std::vector<Found> found_;
    std::vector<Rect> suppressed_;
};

/* The places of the whole image that can be candidates: upper bounds of 4 x 4 places each, see coarseResponses(), and the similarities
   of those that are promising. */
class WholeImageSearch
{
public:
    WholeImageSearch() : ready_(false), margin_(0), step_(0), planeSize_(0) {}

    //! There is another image.
    void forget() { ready_ = false; }
    //! Coarse responses with a margin that the templates fit into. @param spread bits of the roi
    void prepare(const Size& image, const Mat& spread, const Rect& roi, const std::vector<PartTemplate>& templates);
    //! Fills the cells that can hold a candidate. @return they are valid until the next call
    CellMap& search(const PartTemplate& t, const QGOMatcher::Params& params);

private:
    bool ready_;
    int margin_;   // of empty cells
    size_t step_, planeSize_;
    std::vector<uchar> planes_, workspace_;
    std::vector<int> offsets_, cellIndices_;
    std::vector<ushort> bounds_;
    std::vector<uint64> queue_;
    CellMap cellMap_;
};

}} // namespace cv::surgtrack

#endif

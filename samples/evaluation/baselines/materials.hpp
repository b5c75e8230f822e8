// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Colours of a tool's materials, by which Reiter et al. 2012 reject poses; their classes are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_MATERIALS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_MATERIALS_HPP

#include "opencv2/imgproc.hpp"
#include "training.hpp"

namespace evaluation {

//! A normal distribution of colours for tissue, the shaft, and what is beyond the wrist.
class Materials
{
public:
    enum { TISSUE = 0, SHAFT, WRIST, COUNT };

    String name() const { return "materials"; }
    String constants() const { return "materials 1"; }

    //! By ids of a drawing, 1 + link: TISSUE without one, WRIST from the last link but one that a joint moves.
    static std::vector<int> materialsOf(const ToolModel& model)
    {
        int wrist = model.endEffectorLink(), moved = 0;
        for (int link = wrist; link >= 0 && moved < 2; link = model.links()[link].parent)
            if (model.links()[link].coordinate >= 0)
            {
                wrist = link;
                moved++;
            }
        std::vector<int> materials(1 + model.links().size(), SHAFT);
        materials[0] = TISSUE;
        std::fill(materials.begin() + 1 + wrist, materials.end(), int(WRIST));
        return materials;
    }

    //! From drawings at the true pose.
    void train(const Training& training, bool)
    {
        const Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
        std::vector<double> counts(COUNT, 0.);
        std::vector<Vec3d> sums(COUNT);
        std::vector<Matx33d> squares(COUNT);
        training.scenes(6, [&](const Data& data, TrueParts& parts, const Mat& image) {
            const Mat colour = colourOf(image);
            Mat all = Mat::zeros(image.size(), CV_8U);
            for (int tool = 0; tool < (int)data.tools.size(); tool++)
            {
                const Truth& truth = parts.truth(tool);
                if (truth.joints.empty())
                    return;
                Mat depth, ids, shading;
                renderer->renderTool(data.tools[tool].model, truth.joints, data.camera_T_base(tool, truth.camera_T_tool, truth.joints),
                                     parts.finder().camera(), depth, ids, shading);
                const std::vector<int> materials = materialsOf(*data.tools[tool].model);
                for (int y = 0; y < all.rows; y++)
                    for (int x = 0; x < all.cols; x++)
                        all.at<uchar>(y, x) = std::max(all.at<uchar>(y, x), (uchar)materials[ids.at<uchar>(y, x)]);
            }
            for (int y = 0; y < all.rows; y += 3)
                for (int x = 0; x < all.cols; x += 3)
                {
                    const int k = all.at<uchar>(y, x);
                    const Vec3d c = colour.at<Vec3b>(y, x);
                    counts[k]++;
                    sums[k] += c;
                    squares[k] += c * c.t();
                }
        });
        mean_.create(COUNT, 3, CV_64F);
        covariance_.create(COUNT, 9, CV_64F);
        for (int k = 0; k < COUNT; k++)
        {
            const Vec3d m = sums[k] * (1 / std::max(counts[k], 1.));
            const Matx33d C = squares[k] * (1 / std::max(counts[k], 1.)) - m * m.t() + Matx33d::eye() * 4;   // 4: grey levels have noise
            std::copy(m.val, m.val + 3, mean_.ptr<double>(k));
            std::copy(C.val, C.val + 9, covariance_.ptr<double>(k));
        }
    }
    void write(FileStorage& file) const { file << "mean" << mean_ << "covariance" << covariance_; }
    bool read(const FileNode& node)
    {
        node["mean"] >> mean_;
        node["covariance"] >> covariance_;
        return mean_.size() == Size(3, COUNT) && covariance_.size() == Size(9, COUNT) && mean_.type() == CV_64F && covariance_.type() == CV_64F;
    }

    //! The share of a drawn tool's pixels whose colour is most likely that of their material. @param ids of the drawing
    double agreement(const Mat& image, const Mat& ids, const ToolModel& model) const
    {
        const Mat colour = colourOf(image);
        Vec3d mean[COUNT];
        Matx33d inverse[COUNT];
        double constant[COUNT];
        for (int k = 0; k < COUNT; k++)
        {
            const Matx33d C(covariance_.ptr<double>(k));
            mean[k] = Vec3d(mean_.ptr<double>(k));
            inverse[k] = C.inv();
            constant[k] = std::log(determinant(C));
        }
        const std::vector<int> materials = materialsOf(model);
        int drawn = 0, right = 0;
        for (int y = 0; y < ids.rows; y += 2)
            for (int x = 0; x < ids.cols; x += 2)
            {
                const int id = ids.at<uchar>(y, x);
                if (id == 0)
                    continue;
                double least = DBL_MAX;
                int nearest = 0;
                for (int k = 0; k < COUNT; k++)
                {
                    const Vec3d d = Vec3d(colour.at<Vec3b>(y, x)) - mean[k];
                    const double cost = d.dot(inverse[k] * d) + constant[k];
                    if (cost >= least)
                        continue;
                    least = cost;
                    nearest = k;
                }
                drawn++;
                right += nearest == materials[id];
            }
        return drawn ? double(right) / drawn : 0;
    }

private:
    static Mat colourOf(const Mat& image)
    {
        Mat colour = image;
        if (image.channels() == 1)
            cvtColor(image, colour, COLOR_GRAY2BGR);
        return colour;
    }
    Mat mean_, covariance_;
};

} // namespace evaluation

#endif

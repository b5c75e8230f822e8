// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <locale>
#include <sstream>
#include "opencv2/surgtrack/sequence.hpp"
#include "opencv2/surgtrack/tracking_state.hpp"
#include "base/geometry.hpp"
#ifdef _WIN32
#include <io.h>
#else
#include <unistd.h>
#endif

namespace cv { namespace surgtrack {

namespace {

bool isName(const String& name)
{
    return !name.empty() && name.find_first_of(",\"\r\n") == String::npos;
}

// Names of what an estimate says beside its pose, but for the joints' offsets.
const char* const evidenceColumns[] = {"visible", "inliers", "similarity", "contour", "nis", "sd_rx", "sd_ry", "sd_rz", "sd_tx", "sd_ty", "sd_tz"};

// coordinates: whose offset goes into each of the columns; -1: the tool has no such coordinate
struct WrittenTool
{
    String name;
    std::vector<int> coordinates;
};

class PoseWriterImpl CV_FINAL : public PoseWriter
{
public:
    PoseWriterImpl(const String& filename, const std::vector<String>& extraColumns, const std::vector<WrittenTool>& tools)
        : filename_(filename), tools_(tools), extraColumns_(extraColumns.size()), file_(std::fopen(filename.c_str(), "wb")), size_(0)
    {
        if (!file_)
            CV_Error(Error::StsError, format("%s: can't be written: %s", filename.c_str(), std::strerror(errno)));
        std::setvbuf(file_, 0, _IONBF, 0);   // a row goes out whole, and nothing is left to be written when the file is closed
        String header = "frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw";
        for (size_t i = 0; i < extraColumns.size(); i++)
            header += "," + extraColumns[i];
        try
        {
            put(header + "\n");
        }
        catch (...)
        {
            std::fclose(file_);
            throw;
        }
    }

    ~PoseWriterImpl() CV_OVERRIDE { std::fclose(file_); }

    void write(int frame, double time, const String& tool, int state, const Matx44d& camera_T_tool,
               const std::vector<double>& extra) CV_OVERRIDE
    {
        const Matx33d R = camera_T_tool.get_minor<3, 3>(0, 0);
        CV_Assert(checkRange(camera_T_tool) && "camera_T_tool must be finite");
        // 1e-3: far more than rounding, far less than the scale or shear of a wrong matrix.
        CV_Assert(norm(R * R.t(), Matx33d::eye(), NORM_INF) < 1e-3 && determinant(R) > 0 && "camera_T_tool must be rigid");
        CV_Assert(!cvIsNaN(time) && !cvIsInf(time) && "time must be finite");
        CV_Assert(isName(tool) && "tool must be a name without comma, quote and line break");
        CV_CheckEQ(extra.size(), extraColumns_, "one value per further column");

        const Vec4d q = quaternionFromRotation(R);
        std::ostringstream row;
        row.imbue(std::locale::classic());
        row << frame << ',';
        row.setf(std::ios::fixed);
        row.precision(6);
        row << time << ',' << tool << ',' << stateName(state);
        row.precision(9);
        for (int i = 0; i < 3; i++)
            row << ',' << camera_T_tool(i, 3);
        for (int i = 0; i < 4; i++)
            row << ',' << q[i];
        row.unsetf(std::ios::floatfield);
        row.precision(6);
        for (size_t i = 0; i < extra.size(); i++)
        {
            row << ',';
            if (!cvIsNaN(extra[i]) && !cvIsInf(extra[i]))
                row << extra[i];
        }
        row << '\n';
        put(row.str());
    }

    void write(int frame, double time, const String& tool, const ToolEstimate& e, const std::vector<double>& extra) CV_OVERRIDE
    {
        if (tools_.empty()) CV_Error(Error::StsBadArg, "the file was not begun for estimates, expected create() with tools and models");
        size_t index = 0;
        while (index < tools_.size() && tools_[index].name != tool) index++;
        if (index == tools_.size()) CV_Error(Error::StsBadArg, format("tool '%s' is none of those given to create()", tool.c_str()));
        const double nothing = std::numeric_limits<double>::quiet_NaN();
        const double evidence[] = {double(e.visibleParts), double(e.inliers), e.similarity, e.contourSupport, e.nis};
        std::vector<double> row(evidence, evidence + 5);
        for (int i = 0; i < 6; i++) row.push_back(e.covariance(i, i) > 0 ? std::sqrt(e.covariance(i, i)) : nothing);
        const std::vector<int>& coordinates = tools_[index].coordinates;
        for (size_t i = 0; i < coordinates.size(); i++)
        {
            const int k = coordinates[i];
            row.push_back(k >= 0 && k < int(e.jointOffsets.size()) ? e.jointOffsets[k] : nothing);
        }
        row.insert(row.end(), extra.begin(), extra.end());
        write(frame, time, tool, e.state, e.camera_T_tool, row);
    }

private:
    void put(const String& row)
    {
        if (std::fwrite(row.data(), 1, row.size(), file_) == row.size() && std::fflush(file_) == 0)
        {
            size_ += (int64)row.size();
            return;
        }
        const String reason = std::strerror(errno);
        // What the disk took of the row goes away again. On a device this does nothing, and there is nothing to do.
#ifdef _WIN32
        const bool cut = _chsize_s(_fileno(file_), size_) == 0;
#else
        const bool cut = ftruncate(fileno(file_), (off_t)size_) == 0;
#endif
        if (cut)
            std::fseek(file_, 0, SEEK_END);
        CV_Error(Error::StsError, format("%s: can't be written: %s", filename_.c_str(), reason.c_str()));
    }

    String filename_;
    std::vector<WrittenTool> tools_;   // of estimates
    size_t extraColumns_;
    FILE* file_;
    int64 size_;   // of the complete rows
};

} // namespace

static Ptr<PoseWriter> begin(const String& filename, const std::vector<String>& columns, const std::vector<WrittenTool>& tools)
{
    for (size_t i = 0; i < columns.size(); i++)
        CV_Assert(isName(columns[i]) && "a column must have a name without comma, quote and line break");
    return makePtr<PoseWriterImpl>(filename, columns, tools);
}

Ptr<PoseWriter> PoseWriter::create(const String& filename, const std::vector<String>& extraColumns)
{
    return begin(filename, extraColumns, std::vector<WrittenTool>());
}

Ptr<PoseWriter> PoseWriter::create(const String& filename, const std::vector<String>& tools, const std::vector<Ptr<ToolModel> >& models,
                                   const std::vector<String>& extraColumns)
{
    CV_CheckEQ(tools.size(), models.size(), "one model per tool");
    CV_Assert(!tools.empty());
    for (size_t i = 0; i < tools.size(); i++)
        for (size_t k = 0; k < i; k++)
            if (tools[i] == tools[k]) CV_Error(Error::StsBadArg, format("tools[%d]: expected another name for each tool, '%s' is there twice", int(i), tools[i].c_str()));
    for (size_t i = 0; i < models.size(); i++)
        if (!models[i]) CV_Error(Error::StsBadArg, format("models[%d] is empty", int(i)));
    std::vector<String> columns(evidenceColumns, evidenceColumns + sizeof(evidenceColumns) / sizeof(*evidenceColumns));
    const std::vector<String> coordinates = models[0]->coordinateNames();
    std::vector<WrittenTool> written(tools.size());
    for (size_t i = 0; i < tools.size(); i++) written[i].name = tools[i];
    for (size_t k = 0; k < coordinates.size(); k++)
    {
        columns.push_back("offset_" + coordinates[k]);
        for (size_t i = 0; i < tools.size(); i++) written[i].coordinates.push_back(models[i]->coordinateIndex(coordinates[k]));
    }
    columns.insert(columns.end(), extraColumns.begin(), extraColumns.end());
    return begin(filename, columns, written);
}

}} // namespace cv::surgtrack

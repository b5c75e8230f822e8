// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
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

class PoseWriterImpl CV_FINAL : public PoseWriter
{
public:
    PoseWriterImpl(const String& filename, const std::vector<String>& extraColumns)
        : filename_(filename), extraColumns_(extraColumns.size()), file_(std::fopen(filename.c_str(), "wb")), size_(0)
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
    size_t extraColumns_;
    FILE* file_;
    int64 size_;   // of the complete rows
};

} // namespace

Ptr<PoseWriter> PoseWriter::create(const String& filename, const std::vector<String>& extraColumns)
{
    for (size_t i = 0; i < extraColumns.size(); i++)
        CV_Assert(isName(extraColumns[i]) && "a column must have a name without comma, quote and line break");
    return makePtr<PoseWriterImpl>(filename, extraColumns);
}

}} // namespace cv::surgtrack

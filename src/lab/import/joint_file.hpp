// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_IMPORT_JOINT_FILE_HPP
#define OPENCV_SURGTRACK_SRC_LAB_IMPORT_JOINT_FILE_HPP

#include "files/csv.hpp"

namespace cv { namespace surgtrack {

//! Where a joint stands in a row: a column, or an item of the list that is in it.
struct JointCell
{
    int column, item;   // item: -1 = no list
    double unit;        // by the column's name, in rad or m; 0 = not said
};

//! The readings of a joint, of the rows that have one.
struct JointSeries
{
    JointSeries(const JointCell& where, int whose) : cell(where), coordinate(whose) {}
    JointCell cell;
    int coordinate;
    std::vector<double> times, values;
};

/** A CSV file of joint readings as recorders write them. Joints are known by the names of the columns (`yaw`, `/arm/yaw/position`), by
names in the rows (`name0` of `position0`; lists `name` and `position`), or by the places of the positions. */
class JointFile
{
public:
    explicit JointFile(const String& filename);

    //! A cell of this coordinate, or of the column of this name. @return false: there is none
    bool find(const String& coordinate, JointCell& cell) const;
    bool findColumn(const String& name, JointCell& cell) const;
    //! The cell of position 0, 1, ...
    bool findPosition(int index, JointCell& cell) const;

    //! Fills times [s] and values of these.
    void read(std::vector<JointSeries>& series) const;

    CV_NORETURN void fail(const String& what) const;

private:
    //! A time; unit: seconds per unit, 0 = it is not said
    struct TimeColumn { int whole, fraction; double unit; };

    std::vector<TimeColumn> timeColumns(const CsvReader& csv) const;
    void chooseTime();
    void readNames(const CsvReader& csv);
    double timeOf(const CsvReader& csv) const;
    void toSeconds(std::vector<JointSeries>& series) const;

    String filename_;
    std::vector<String> header_;
    TimeColumn time_;
    std::vector<JointCell> positions_;   // by their index
    std::vector<String> names_;          // of the positions, in the first row; empty if it does not name all
};

}} // namespace cv::surgtrack

#endif

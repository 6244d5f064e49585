// Tables of reference numbers: a heading, then rows of cells separated by commas.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace deformable_sim::test {

/// One row by the names of the columns.
class TableRow {
 public:
  TableRow(const std::vector<std::string>& heading, const std::vector<std::string>& cells) {
    for (size_t k = 0; k < heading.size() && k < cells.size(); ++k) cell_[heading[k]] = cells[k];
  }
  const std::string& text(const std::string& column) const {
    static const std::string kNone;
    const auto it = cell_.find(column);
    EXPECT_TRUE(it != cell_.end()) << "no column " << column;
    return it == cell_.end() ? kNone : it->second;
  }
  double operator()(const std::string& column) const { return std::stod(text(column)); }

 private:
  std::map<std::string, std::string> cell_;
};

/// Cells of a line; a cell in double quotes may hold commas.
inline std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

/// test/verify/data/NAME.
inline std::vector<TableRow> read_rows(const std::string& name) {
  std::ifstream file(std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/verify/data/" + name);
  EXPECT_TRUE(file.good()) << name;
  std::vector<TableRow> rows;
  std::vector<std::string> heading;
  for (std::string line; std::getline(file, line);) {
    if (heading.empty()) {
      heading = cells_of(line);
    } else {
      rows.emplace_back(heading, cells_of(line));
    }
  }
  return rows;
}

}  // namespace deformable_sim::test

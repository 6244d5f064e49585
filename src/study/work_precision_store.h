// Runs on disk, so that a study that was interrupted goes on where it stopped.
#pragma once

#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "work_precision.h"

namespace deformable_sim::work_precision {

/// Digest of this executable: results of another build are not mixed with its own.
std::string program_version();

/// One comma-separated line per run: who made it (digest of the scene, version of the program), what, and the results.
/// Texts must not contain commas or line breaks; those in a note are replaced.
std::string row_header();
std::string row_text(const Row& row);
/// Throws InputError.
Row row_of_text(const std::string& line);

/// The same by name, for JSON.
struct RowField {
  std::string name, text;
  bool is_number;
};
std::vector<RowField> row_fields(const Row& row);

/// A file that each finished run is appended to.
class RunLog {
 public:
  enum class Start { kAnew, kResume };
  /// Keeps nothing on disk.
  RunLog() = default;
  /// Resuming, reads the runs of the same scene and program; others stay in the file. Throws InputError when the file
  /// cannot be written or is no such file.
  RunLog(const std::string& path, const std::string& digest, const std::string& version, Start start);

  /// Null: not run yet.
  const Row* find(const Configuration& configuration) const;
  void append(const Row& row);
  size_t known() const { return rows_.size(); }

 private:
  void read(const std::string& path);
  std::string who_;  // "digest,version,"
  std::map<std::string, Row> rows_;
  std::ofstream stream_;
};

/// The whole reference as text, exact.
void write_reference(const std::string& path, const std::string& digest, const std::string& version,
                     const Reference& reference);
/// False: there is none of this scene and program.
bool read_reference(const std::string& path, const std::string& digest, const std::string& version,
                    Reference* reference);

}  // namespace deformable_sim::work_precision

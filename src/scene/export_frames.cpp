#include "deformable_sim/scene/export_frames.h"

#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

const char* extension(FrameFormat format) {
  switch (format) {
    case FrameFormat::kCsv:
      return ".csv";
    case FrameFormat::kPly:
      return ".ply";
    case FrameFormat::kObj:
      return ".obj";
  }
  return "";
}

std::string numbers(const Vec3& p, char separator) {
  char text[96];
  std::snprintf(text, sizeof text, "%.17g%c%.17g%c%.17g", p.x(), separator, p.y(), separator, p.z());
  return text;
}

std::string csv(const Body& body, const Nodes& x, const Nodes& v) {
  std::string text = "node,x,y,z,vx,vy,vz\n";
  for (int i = 0; i < body.node_count; ++i) {
    const int node = body.first_node + i;
    text += std::to_string(i) + "," + numbers(x.col(node), ',') + "," + numbers(v.col(node), ',') + "\n";
  }
  return text;
}

std::string ply(const Body& body, const Nodes& x, const Nodes& v) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(body.node_count) + "\n";
  for (const char* name : {"x", "y", "z", "vx", "vy", "vz"}) text += std::string("property double ") + name + "\n";
  if (body.surface) {
    text +=
        "element face " + std::to_string(body.surface->triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  } else {
    text +=
        "element edge " + std::to_string(body.line->segment_count()) + "\nproperty int vertex1\nproperty int vertex2\n";
  }
  text += "end_header\n";
  for (int i = 0; i < body.node_count; ++i) {
    const int node = body.first_node + i;
    text += numbers(x.col(node), ' ') + " " + numbers(v.col(node), ' ') + "\n";
  }
  if (body.surface) {
    for (const std::array<int, 3>& t : body.surface->triangles) {
      text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
    }
  } else {
    for (int s = 0; s < body.line->segment_count(); ++s) {
      const std::array<int, 2> ends = body.line->segment(s);
      text += std::to_string(ends[0]) + " " + std::to_string(ends[1]) + "\n";
    }
  }
  return text;
}

std::string obj(const Body& body, const Nodes& x, const Nodes& v) {
  std::string text = "o " + body.name + "\n";
  for (int i = 0; i < body.node_count; ++i) text += "v " + numbers(x.col(body.first_node + i), ' ') + "\n";
  for (int i = 0; i < body.node_count; ++i) text += "#v " + numbers(v.col(body.first_node + i), ' ') + "\n";
  if (body.surface) {
    for (const std::array<int, 3>& t : body.surface->triangles) {
      text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
    }
  } else {
    for (int s = 0; s < body.line->segment_count(); ++s) {
      const std::array<int, 2> ends = body.line->segment(s);
      text += "l " + std::to_string(ends[0] + 1) + " " + std::to_string(ends[1] + 1) + "\n";
    }
  }
  return text;
}

}  // namespace

FrameFormat frame_format(const std::string& name) {
  if (name == "csv") return FrameFormat::kCsv;
  if (name == "ply") return FrameFormat::kPly;
  if (name == "obj") return FrameFormat::kObj;
  throw InputError("unknown format '" + name + "'; allowed: csv, ply, obj");
}

std::string frame_text(const Body& body, const Nodes& x, const Nodes& v, FrameFormat format) {
  switch (format) {
    case FrameFormat::kCsv:
      return csv(body, x, v);
    case FrameFormat::kPly:
      return ply(body, x, v);
    case FrameFormat::kObj:
      return obj(body, x, v);
  }
  return "";
}

FrameWriter::FrameWriter(const std::string& dir, FrameFormat format) : dir_(dir), format_(format) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  index_.open(dir + "/frames.csv");
  if (!index_) throw InputError(dir + ": cannot be written to");
  index_ << "frame,time\n";
}

void FrameWriter::write(const Snapshot& snapshot) {
  char number[16];
  std::snprintf(number, sizeof number, "%06d", frames_);
  for (const Body& body : snapshot.model->bodies) {
    const std::string path = dir_ + "/" + body.name + "_" + number + extension(format_);
    std::ofstream file(path);
    file << frame_text(body, snapshot.x, snapshot.v, format_);
    file.close();
    if (!file) throw std::runtime_error(path + ": cannot be written");
  }
  char time[32];
  std::snprintf(time, sizeof time, "%.17g", snapshot.time);
  index_ << frames_ << "," << time << "\n" << std::flush;
  if (!index_) throw std::runtime_error(dir_ + "/frames.csv: cannot be written");
  ++frames_;
}

}  // namespace deformable_sim

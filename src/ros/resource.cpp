#include "deformable_sim/ros/resource.h"

#include <resource_retriever/retriever.h>

#include "deformable_sim/core/error.h"

namespace deformable_sim {

std::string read_resource(const std::string& url) {
  try {
    resource_retriever::Retriever retriever;
    const resource_retriever::MemoryResource file = retriever.get(url);
    return {reinterpret_cast<const char*>(file.data.get()), file.size};
  } catch (const resource_retriever::Exception& error) {
    throw InputError(error.what(), Code::kNotFound);
  }
}

}  // namespace deformable_sim

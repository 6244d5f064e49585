// What advertises topics is made and destroyed one at a time.
#pragma once

#include <memory>
#include <mutex>

namespace deformable_sim {

/// roscpp (1.15 and 1.17) is not safe against advertising and unadvertising on two threads at once:
/// TopicManager::unadvertise looks a publication up, lets go of its lock, and then erases by the place it found and
/// tells the master. A topic advertised again in between is lost to the master, or another one is erased. Scenes are
/// loaded, replaced and destroyed on several threads, so everything that advertises comes from one of these.
class Advertiser {
 public:
  /// `make` returns a std::unique_ptr; it and the destruction of what it made never overlap with others'.
  template <typename Make>
  auto make(Make make) const {
    using T = typename decltype(make())::element_type;
    const std::lock_guard<std::mutex> lock(*mutex_);
    return std::shared_ptr<T>(make().release(), [mutex = mutex_](T* made) {
      const std::lock_guard<std::mutex> lock_again(*mutex);
      delete made;
    });
  }

 private:
  std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();
};

}  // namespace deformable_sim

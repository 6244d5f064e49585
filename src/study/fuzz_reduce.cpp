#include "fuzz_reduce.h"

#include <cmath>
#include <locale>
#include <optional>
#include <sstream>

namespace deformable_sim::fuzz {
namespace {

/// Calls visit(parent, index in it) for every item, parents before children, until it returns true.
template <class Visit>
bool walk(Tree* tree, const Visit& visit) {
  for (size_t k = 0; k < tree->items.size(); ++k) {
    if (visit(tree, k)) return true;
    if (walk(&tree->items[k].second, visit)) return true;
  }
  return false;
}

/// The tree without its n-th item, counted as walk() does; none: there are not so many.
std::optional<Tree> without(const Tree& tree, int n) {
  Tree copy = tree;
  const bool done = walk(&copy, [&n](Tree* parent, size_t k) {
    if (n-- > 0) return false;
    parent->items.erase(parent->items.begin() + static_cast<long>(k));
    return true;
  });
  return done ? std::optional<Tree>(copy) : std::nullopt;
}

/// Smaller or rounder numbers to try in place of this one, the boldest first.
std::vector<std::string> simpler(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  if (!(stream >> value) || !stream.eof()) return {};
  std::vector<std::string> tries;
  const auto add = [&](const std::string& other) {
    if (other != text) tries.push_back(other);
  };
  if (value == 0.0) return {};
  add("0");
  const bool whole = text.find_first_not_of("0123456789") == std::string::npos;
  if (whole && value > 1) {
    add(std::to_string(static_cast<long>(value) / 2));
    add(std::to_string(static_cast<long>(value) - 1));
  }
  if (!whole) {
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))));
    add(number_text(std::round(value / unit) * unit));
    add(number_text(std::round(value / unit * 10.0) * unit / 10.0));
  }
  return tries;
}

/// All numbers of the tree, as walk() counts items.
std::vector<std::pair<int, std::string>> scalars(const Tree& tree) {
  std::vector<std::pair<int, std::string>> found;
  Tree copy = tree;
  int n = 0;
  walk(&copy, [&](Tree* parent, size_t k) {
    const Tree& item = parent->items[k].second;
    if (item.kind == Tree::Kind::kScalar) found.emplace_back(n, item.text);
    ++n;
    return false;
  });
  return found;
}

Tree with(const Tree& tree, int n, const std::string& text) {
  Tree copy = tree;
  walk(&copy, [&](Tree* parent, size_t k) {
    if (n-- > 0) return false;
    parent->items[k].second.text = text;
    return true;
  });
  return copy;
}

class Reduction {
 public:
  Reduction(const Case& failing, const std::function<bool(const Case&)>& fails, int most)
      : best(failing), fails_(fails), left_(most) {}

  Case best;

  bool leave_out() {
    bool any = false;
    for (size_t k = best.commands.size(); k-- > 0;) {
      Case trial = best;
      trial.commands.erase(trial.commands.begin() + static_cast<long>(k));
      any = accept(trial) || any;
    }
    for (int n = 0;;) {
      const std::optional<Tree> smaller = without(best.scene, n);
      if (!smaller) return any;
      if (accept({*smaller, best.commands})) {
        any = true;
      } else {
        ++n;
      }
    }
  }

  bool simplify() {
    bool any = false;
    for (const auto& [n, text] : scalars(best.scene)) {
      for (const std::string& other : simpler(text)) {
        if (!accept({with(best.scene, n, other), best.commands})) continue;
        any = true;
        break;
      }
    }
    return any;
  }

  bool exhausted() const { return left_ <= 0; }

 private:
  bool accept(const Case& trial) {
    if (left_ <= 0) return false;
    --left_;
    if (!fails_(trial)) return false;
    best = trial;
    return true;
  }

  const std::function<bool(const Case&)>& fails_;
  int left_;
};

}  // namespace

Case reduce(const Case& failing, const std::function<bool(const Case&)>& fails, int most) {
  Reduction r(failing, fails, most);
  bool changed = true;
  while (changed && !r.exhausted()) {
    changed = r.leave_out();
    changed = r.simplify() || changed;
  }
  return r.best;
}

}  // namespace deformable_sim::fuzz

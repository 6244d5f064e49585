#include "work_precision_front.h"

#include <algorithm>
#include <numeric>

namespace deformable_sim::work_precision {

namespace {

constexpr double kSame = 1e-5;  // of an error: schemes that differ in the order of their sums alone

}  // namespace

const std::vector<double>& wanted_errors() {
  static const std::vector<double> kWanted = {0.02, 0.01, 0.003, 0.001, 0.0001};
  return kWanted;
}

std::vector<int> pareto_front(const std::vector<Row>& rows, double resolution) {
  const auto at = [&rows](int k) -> const Row& { return rows[static_cast<size_t>(k)]; };
  const auto error = [&](int k) { return std::max(at(k).errors.position, resolution); };
  std::vector<int> order(rows.size());
  std::iota(order.begin(), order.end(), 0);
  order.erase(std::remove_if(order.begin(), order.end(),
                             [&](int k) {
                               return at(k).status != Status::kDone || std::isnan(at(k).errors.position) ||
                                      std::isnan(at(k).cost.cpu);
                             }),
              order.end());
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return at(a).cost.cpu != at(b).cost.cpu ? at(a).cost.cpu < at(b).cost.cpu : error(a) < error(b);
  });
  std::vector<int> front;
  double least = std::numeric_limits<double>::infinity();
  for (const int k : order) {
    if (error(k) >= (1.0 - kSame) * least) continue;
    least = error(k);
    front.push_back(k);
  }
  return front;
}

std::vector<Pick> picks(const std::vector<Row>& rows, double resolution) {
  const std::vector<int> front = pareto_front(rows, resolution);
  std::vector<Pick> found;
  for (const double wanted : wanted_errors()) {
    Pick pick;
    pick.wanted = wanted;
    if (!(resolution <= wanted)) {
      pick.why = "the reference does not resolve it";
    } else {
      const auto first = std::find_if(front.begin(), front.end(), [&](int k) {
        return std::max(rows[static_cast<size_t>(k)].errors.position, resolution) <= wanted;
      });
      if (first != front.end()) pick.row = *first;
      if (first == front.end()) pick.why = "no run reached it";
    }
    found.push_back(pick);
  }
  return found;
}

}  // namespace deformable_sim::work_precision

// Numbers as people read them.
#pragma once

#include <QString>

namespace deformable_sim {

/// Three significant digits and an SI prefix: with_unit(0.00123, "J") is "1.23 mJ". Percent and numbers without a unit
/// have no prefix, and two decimals at most.
QString with_unit(double value, const QString& unit);

}  // namespace deformable_sim

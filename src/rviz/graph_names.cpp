#include "deformable_sim/rviz/graph_names.h"

#include <QRegularExpression>

namespace deformable_sim {

QString node_name_pattern() {
  return QStringLiteral("/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*");
}

bool is_node_name(const QString& name) {
  return name.size() <= 256 &&
         QRegularExpression(QRegularExpression::anchoredPattern(node_name_pattern())).match(name).hasMatch();
}

}  // namespace deformable_sim

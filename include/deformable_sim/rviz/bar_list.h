// Rows of a name, a bar and a text.
#pragma once

#include <vector>

#include <QColor>
#include <QString>
#include <QWidget>

namespace deformable_sim {

class BarList : public QWidget {
  Q_OBJECT

 public:
  struct Row {
    QString name;
    double fraction;  // of the bar's full length, clamped to 0 ... 1
    QString text;
    QColor color;
  };

  explicit BarList(QWidget* parent = nullptr);

  void set_rows(std::vector<Row> rows);
  const std::vector<Row>& rows() const { return rows_; }

  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  int row_height() const;

  std::vector<Row> rows_;
};

}  // namespace deformable_sim

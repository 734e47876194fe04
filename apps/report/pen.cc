#include "apps/report/pen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace kinegraph {
namespace {

// Digits and minus, five rows of three cells each, from the top; a bit a cell,
// the left one first.
constexpr std::array<std::array<uint8_t, 5>, 11> kGlyphs = {{{7, 5, 5, 5, 7},
                                                             {2, 6, 2, 2, 7},
                                                             {7, 1, 7, 4, 7},
                                                             {7, 1, 7, 1, 7},
                                                             {5, 5, 7, 1, 1},
                                                             {7, 4, 7, 1, 7},
                                                             {7, 4, 7, 5, 7},
                                                             {7, 1, 2, 2, 2},
                                                             {7, 5, 7, 5, 7},
                                                             {7, 5, 7, 1, 7},
                                                             {0, 0, 7, 0, 0}}};

uint8_t Mixed(uint8_t below, uint8_t above, double share) {
  return static_cast<uint8_t>(
      std::lround(below + share * (static_cast<double>(above) - below)));
}

// First and last whole pixel of a span that are inside of 0 .. size - 1.
std::array<int, 2> Inside(double low, double high, int size) {
  const double first = std::clamp(std::floor(low), 0.0, double(size));
  const double last = std::clamp(std::ceil(high), -1.0, double(size) - 1.0);
  return {static_cast<int>(first), static_cast<int>(last)};
}

}  // namespace

void Pen::Blend(int x, int y, Colour colour, double share) {
  uint8_t* const pixel = picture_.At(x, y);
  pixel[0] = Mixed(pixel[0], colour.red, share);
  pixel[1] = Mixed(pixel[1], colour.green, share);
  pixel[2] = Mixed(pixel[2], colour.blue, share);
}

void Pen::Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               const Stroke& stroke) {
  if (!from.allFinite() || !to.allFinite()) return;
  const double reach = 0.5 * stroke.width_px + 0.5;
  const auto [top, bottom] =
      Inside(std::min(from.y(), to.y()) - reach,
             std::max(from.y(), to.y()) + reach, picture_.height);
  const auto [left, right] =
      Inside(std::min(from.x(), to.x()) - reach,
             std::max(from.x(), to.x()) + reach, picture_.width);
  const Eigen::Vector2d along = to - from;
  const double squared = along.squaredNorm();
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - from;
      const double share =
          squared > 0.0 ? std::clamp(offset.dot(along) / squared, 0.0, 1.0)
                        : 0.0;
      const double distance = (offset - share * along).norm();
      const double cover = std::clamp(reach - distance, 0.0, 1.0);
      if (cover > 0.0) Blend(x, y, stroke.colour, cover * stroke.opacity);
    }
  }
}

void Pen::Disc(const Eigen::Vector2d& middle, double radius_px, Colour colour) {
  Line(middle, middle, {colour, 2.0 * radius_px, 1.0});
}

void Pen::Box(double left, double top, double right, double bottom,
              Colour colour) {
  const auto [first_x, last_x] = Inside(left, right, picture_.width);
  const auto [first_y, last_y] = Inside(top, bottom, picture_.height);
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) Blend(x, y, colour, 1.0);
  }
}

void Pen::Number(int64_t number, const Eigen::Vector2d& at, double height_px,
                 Colour colour, Colour ground) {
  if (!at.allFinite()) return;
  const std::string digits = std::to_string(number);
  const double cell = std::max(1.0, std::round(height_px / 5.0));
  const double left = std::round(at.x());
  const double top = std::round(at.y()) - 5.0 * cell;
  const double width = (4.0 * static_cast<double>(digits.size()) - 1.0) * cell;
  Box(left - cell, top - cell, left + width + cell - 1.0,
      top + 6.0 * cell - 1.0, ground);
  for (size_t d = 0; d < digits.size(); ++d) {
    const size_t glyph =
        digits[d] == '-' ? 10 : static_cast<size_t>(digits[d] - '0');
    for (int row = 0; row < 5; ++row) {
      for (int column = 0; column < 3; ++column) {
        const int bit = 4 >> column;
        if ((kGlyphs[glyph][static_cast<size_t>(row)] & bit) == 0) continue;
        const double x = left + (4.0 * static_cast<double>(d) + column) * cell;
        const double y = top + row * cell;
        Box(x, y, x + cell - 1.0, y + cell - 1.0, colour);
      }
    }
  }
}

}  // namespace kinegraph

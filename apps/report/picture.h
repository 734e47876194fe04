// Pictures behind the page's panels: read, scaled down, drawn upon, written.
#ifndef KINEGRAPH_APPS_REPORT_PICTURE_H_
#define KINEGRAPH_APPS_REPORT_PICTURE_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kinegraph {

// 8 bits a channel, rows from the top, red first.
struct Picture {
  int width = 0;   // px
  int height = 0;  // px
  std::vector<uint8_t> rgb;

  uint8_t* At(int x, int y) {
    return &rgb[3 * (static_cast<size_t>(y) * static_cast<size_t>(width) +
                     static_cast<size_t>(x))];
  }
  const uint8_t* At(int x, int y) const {
    return const_cast<Picture*>(this)->At(x, y);
  }
};

struct Colour {
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
};

Picture MakePicture(int width, int height, Colour colour);

// JPEG or PNG, told by content. Throws InputError naming the file: another
// kind, a broken one, one larger than 100 megapixels.
Picture ReadPicture(const std::string& path);

// Not wider than `width`; each pixel is the mean of those it covers.
Picture ScaledDown(const Picture& picture, int width);

// JPEG; `quality` 1 to 100.
std::string EncodeJpeg(const Picture& picture, int quality);

struct Stroke {
  Colour colour;
  double width_px = 1.0;
  double opacity = 1.0;
};

// Lines, discs and numbers in a picture, with soft edges. What lies outside of
// the picture is left out.
class Pen {
 public:
  explicit Pen(Picture* picture) : picture_(*picture) {}

  // With round ends. Coordinates are pixels, (0, 0) the middle of the first.
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
            const Stroke& stroke);
  void Disc(const Eigen::Vector2d& middle, double radius_px, Colour colour);
  // The digits of `number`, `height_px` high, its lower left corner at `at`, on
  // a ground of its own.
  void Number(int64_t number, const Eigen::Vector2d& at, double height_px,
              Colour colour, Colour ground);

 private:
  void Blend(int x, int y, Colour colour, double share);
  void Box(double left, double top, double right, double bottom, Colour colour);

  Picture& picture_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PICTURE_H_

// Pictures behind the page's panels: read, scaled down, drawn upon, written.
#ifndef KINEGRAPH_APPS_REPORT_PICTURE_H_
#define KINEGRAPH_APPS_REPORT_PICTURE_H_

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

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PICTURE_H_

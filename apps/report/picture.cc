#include "apps/report/picture.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
// libjpeg's header wants size_t and FILE to be known.
#include <jpeglib.h>
// After it.
#include <jerror.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <string>

#include "core/base/error.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

constexpr size_t kMaxFileBytes = 200'000'000;
constexpr int64_t kMaxPixels = 100'000'000;

void CheckSize(const std::string& path, int64_t width, int64_t height,
               size_t file_bytes) {
  const std::string what = "is a picture of " + std::to_string(width) + " x " +
                           std::to_string(height) + " px, ";
  if (width < 1 || height < 1 || width * height > kMaxPixels) {
    throw InputError(path, "", what + "expected at most 100 megapixels");
  }
  // Deflate reaches 1032 bytes for one, JPEG's shortest codes some 1500.
  constexpr int64_t kMostForAByte = 1600;
  constexpr int64_t kSmallBytes = int64_t{32} << 20;
  if (3 * width * height <=
      kSmallBytes + kMostForAByte * static_cast<int64_t>(file_bytes)) {
    return;
  }
  throw InputError(path, "",
                   what + "more than its " + std::to_string(file_bytes) +
                       " bytes can stand for");
}

// A codec of libjpeg, which leaves by longjmp where something is wrong: nothing
// with a destructor may live in what Try() calls.
template <typename Codec>
class Jpeg {
 public:
  Jpeg() {
    codec_.err = jpeg_std_error(&errors_);
    codec_.client_data = &back_;
    errors_.error_exit = [](j_common_ptr codec) {
      std::longjmp(*static_cast<std::jmp_buf*>(codec->client_data), 1);
    };
    errors_.emit_message = [](j_common_ptr, int) {};
    Try([](Codec* codec) { Create(codec); });
  }
  ~Jpeg() { jpeg_destroy(reinterpret_cast<j_common_ptr>(&codec_)); }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;

  // Whether `work` came to its end. Throws std::bad_alloc where memory ended.
  template <typename Work>
  bool Try(const Work& work) {
    if (setjmp(back_) == 0) {
      work(&codec_);
      return true;
    }
    if (errors_.msg_code == JERR_OUT_OF_MEMORY) throw std::bad_alloc();
    return false;
  }
  const Codec& codec() const { return codec_; }

 private:
  static void Create(jpeg_decompress_struct* codec) {
    jpeg_create_decompress(codec);
  }
  static void Create(jpeg_compress_struct* codec) {
    jpeg_create_compress(codec);
  }

  Codec codec_ = {};
  jpeg_error_mgr errors_ = {};
  std::jmp_buf back_;
};

Picture ReadJpeg(const std::string& path, const std::string& bytes) {
  Jpeg<jpeg_decompress_struct> jpeg;
  const InputError broken(path, "", "is a broken JPEG picture");
  int header = JPEG_SUSPENDED;
  jpeg.Try([&](jpeg_decompress_struct* codec) {
    jpeg_mem_src(codec, reinterpret_cast<const unsigned char*>(bytes.data()),
                 static_cast<unsigned long>(bytes.size()));
    header = jpeg_read_header(codec, TRUE);
    codec->out_color_space = JCS_RGB;
  });
  if (header != JPEG_HEADER_OK) throw InputError(broken);
  const int64_t width = jpeg.codec().image_width;
  const int64_t height = jpeg.codec().image_height;
  CheckSize(path, width, height, bytes.size());
  Picture picture =
      MakePicture(static_cast<int>(width), static_cast<int>(height), {});
  const bool is_whole = jpeg.Try([&](jpeg_decompress_struct* codec) {
    jpeg_start_decompress(codec);
    while (codec->output_scanline < codec->output_height) {
      JSAMPROW row = picture.At(0, static_cast<int>(codec->output_scanline));
      jpeg_read_scanlines(codec, &row, 1);
    }
    jpeg_finish_decompress(codec);
  });
  if (!is_whole) throw InputError(broken);
  return picture;
}

Picture ReadPng(const std::string& path, const std::string& bytes) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) ==
      0) {
    throw InputError(path, "", "is a broken PNG picture");
  }
  image.format = PNG_FORMAT_RGB;
  const int64_t width = image.width;
  const int64_t height = image.height;
  const std::unique_ptr<png_image, void (*)(png_image*)> owner(&image,
                                                               png_image_free);
  CheckSize(path, width, height, bytes.size());
  Picture picture =
      MakePicture(static_cast<int>(width), static_cast<int>(height), {});
  const png_color background = {255, 255, 255};
  if (png_image_finish_read(&image, &background, picture.rgb.data(), 0,
                            nullptr) == 0) {
    throw InputError(path, "", "is a broken PNG picture");
  }
  return picture;
}

bool BeginsWith(const std::string& bytes, const std::string& begin) {
  return bytes.compare(0, begin.size(), begin) == 0;
}

}  // namespace

Picture MakePicture(int width, int height, Colour colour) {
  Picture picture;
  picture.width = width;
  picture.height = height;
  const size_t pixels =
      static_cast<size_t>(width) * static_cast<size_t>(height);
  picture.rgb.resize(3 * pixels);
  for (size_t i = 0; i < pixels; ++i) {
    picture.rgb[3 * i] = colour.red;
    picture.rgb[3 * i + 1] = colour.green;
    picture.rgb[3 * i + 2] = colour.blue;
  }
  return picture;
}

Picture ReadPicture(const std::string& path) {
  const std::string bytes = ReadBytes(path, kMaxFileBytes);
  if (BeginsWith(bytes, "\xff\xd8\xff")) return ReadJpeg(path, bytes);
  if (BeginsWith(bytes, "\x89PNG")) return ReadPng(path, bytes);
  throw InputError(path, "", "is no picture that is read: JPEG or PNG");
}

Picture ScaledDown(const Picture& picture, int width) {
  if (picture.width <= width) return picture;
  const int height =
      std::max(1, static_cast<int>(static_cast<int64_t>(picture.height) *
                                   width / picture.width));
  Picture small = MakePicture(width, height, {});
  for (int y = 0; y < height; ++y) {
    const int top = static_cast<int>(int64_t{y} * picture.height / height);
    const int bottom = std::max(
        top + 1, static_cast<int>(int64_t{y + 1} * picture.height / height));
    for (int x = 0; x < width; ++x) {
      const int left = static_cast<int>(int64_t{x} * picture.width / width);
      const int right = std::max(
          left + 1, static_cast<int>(int64_t{x + 1} * picture.width / width));
      int64_t sum[3] = {0, 0, 0};
      for (int v = top; v < bottom; ++v) {
        const uint8_t* from = picture.At(left, v);
        for (int u = left; u < right; ++u) {
          for (int64_t& channel : sum) channel += *from++;
        }
      }
      const int64_t count = int64_t{bottom - top} * (right - left);
      for (int c = 0; c < 3; ++c) {
        small.At(x, y)[c] = static_cast<uint8_t>((sum[c] + count / 2) / count);
      }
    }
  }
  return small;
}

std::string EncodeJpeg(const Picture& picture, int quality) {
  Jpeg<jpeg_compress_struct> jpeg;
  unsigned char* buffer = nullptr;  // of malloc
  unsigned long size = 0;
  const auto release = [](unsigned char** owned) { std::free(*owned); };
  const std::unique_ptr<unsigned char*, decltype(release)> owner(&buffer,
                                                                 release);
  const bool is_done = jpeg.Try([&](jpeg_compress_struct* codec) {
    jpeg_mem_dest(codec, &buffer, &size);
    codec->image_width = static_cast<JDIMENSION>(picture.width);
    codec->image_height = static_cast<JDIMENSION>(picture.height);
    codec->input_components = 3;
    codec->in_color_space = JCS_RGB;
    jpeg_set_defaults(codec);
    jpeg_set_quality(codec, quality, TRUE);
    jpeg_start_compress(codec, TRUE);
    while (codec->next_scanline < codec->image_height) {
      JSAMPROW row = const_cast<uint8_t*>(
          picture.At(0, static_cast<int>(codec->next_scanline)));
      jpeg_write_scanlines(codec, &row, 1);
    }
    jpeg_finish_compress(codec);
  });
  if (!is_done) throw std::runtime_error("a picture could not be encoded");
  return {reinterpret_cast<const char*>(buffer), size};
}

// ---- Drawing ----

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

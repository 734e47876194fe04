// The parameter section of a C3D file. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_C3D_PARAMETERS_H_
#define KINEGRAPH_CORE_IO_TRACKS_C3D_PARAMETERS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kinegraph {

inline constexpr size_t kC3dBlock = 512;

// Bytes in Intel order.
class BinaryText {
 public:
  BinaryText& Byte(int value);
  BinaryText& Word(int64_t value);  // 16 bits
  BinaryText& Float(double value);  // IEEE, 32 bits
  BinaryText& Text(const std::string& text);
  void PadTo(size_t size) { text_.resize(size, '\0'); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Groups with their parameters, in the order in which they are added.
class C3dParameters {
 public:
  C3dParameters& Group(const std::string& name);
  // Parameters of the last group.
  C3dParameters& Word(const std::string& name, int64_t value);
  C3dParameters& Words(const std::string& name,
                       const std::vector<int64_t>& values);
  C3dParameters& Float(const std::string& name, double value);
  C3dParameters& Floats(const std::string& name,
                        const std::vector<size_t>& shape,
                        const std::vector<double>& values);
  // As wide as the longest. Beyond 255 they go on in NAME2, NAME3, ..., and
  // beyond 255 bytes a text is cut.
  C3dParameters& Texts(const std::string& name,
                       const std::vector<std::string>& texts);

  // Whole blocks. Throws InputError when they are more than the 255 that a file
  // can have.
  std::string Section() const;

 private:
  void Record(const std::string& name, int id, const std::string& content);
  C3dParameters& Add(const std::string& name, int type,
                     const std::vector<size_t>& shape, const BinaryText& data);
  void AddTexts(const std::string& name, const std::string* texts,
                size_t count);

  std::string records_;
  size_t last_record_ = 0;
  int group_ = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_C3D_PARAMETERS_H_

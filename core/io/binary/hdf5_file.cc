#include "core/io/binary/hdf5_file.h"

#include <hdf5.h>

#include <algorithm>
#include <functional>
#include <mutex>

#include "core/base/error.h"
#include "core/io/binary/bytes.h"
#include "core/io/files/text_file.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

// As h5py's own lzf is.
constexpr const char* kUnreadable =
    "is damaged, or compressed in a way that HDF5 does not know by itself";

// A handle of the library and what closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  hid_t get() const { return id_; }
  bool is_valid() const { return id_ >= 0; }

 private:
  const hid_t id_;
  herr_t (*const close_)(hid_t);
};

// A data set that is open, its shape and type.
struct DataSet {
  DataSet(hid_t file, const std::string& name)
      : set(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose),
        space(set.is_valid() ? H5Dget_space(set.get()) : -1, H5Sclose),
        type(set.is_valid() ? H5Dget_type(set.get()) : -1, H5Tclose) {
    if (!set.is_valid()) throw InputError("is missing");
  }

  const Handle set;
  const Handle space;
  const Handle type;
};

// What `read` gives of a data set. The file and `label` stand in front of what
// is thrown, or the set's name where there is none.
template <typename Read>
auto ReadSet(const std::string& path, hid_t file, const std::string& name,
             const std::string& label, const Read& read) {
  const std::string* where = &name;
  try {
    const DataSet of(file, name);
    where = &label;
    return read(of);
  } catch (const InputError& error) {
    throw InputError(path, *where, error.what());
  }
}

// Numbers as processors have them. Others the library converts bit by bit, as
// their description says, which may be damaged.
bool IsPlainNumber(hid_t type) {
  for (const hid_t plain :
       {H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE, H5T_IEEE_F64BE,
        H5T_STD_I8LE,   H5T_STD_I8BE,   H5T_STD_I16LE,  H5T_STD_I16BE,
        H5T_STD_I32LE,  H5T_STD_I32BE,  H5T_STD_I64LE,  H5T_STD_I64BE,
        H5T_STD_U8LE,   H5T_STD_U8BE,   H5T_STD_U16LE,  H5T_STD_U16BE,
        H5T_STD_U32LE,  H5T_STD_U32BE,  H5T_STD_U64LE,  H5T_STD_U64BE}) {
    if (H5Tequal(type, plain) > 0) return true;
  }
  return false;
}

// Whether all fields lie within the record.
bool HoldsItsFields(hid_t record) {
  const int fields = H5Tget_nmembers(record);
  const size_t size = H5Tget_size(record);
  for (unsigned i = 0; fields >= 0 && i < static_cast<unsigned>(fields); ++i) {
    const Handle field(H5Tget_member_type(record, i), H5Tclose);
    const size_t begin = H5Tget_member_offset(record, i);
    if (begin > size || size - begin < H5Tget_size(field.get())) return false;
  }
  return fields > 0;
}

std::vector<size_t> ShapeOf(hid_t space) {
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) throw InputError("is damaged");
  std::vector<hsize_t> sides(static_cast<size_t>(rank));
  if (rank > 0) H5Sget_simple_extent_dims(space, sides.data(), nullptr);
  return {sides.begin(), sides.end()};
}

size_t CountOf(const std::vector<size_t>& shape) {
  constexpr size_t kMost = size_t{1} << 31;
  size_t count = 1;
  for (const size_t side : shape) {
    if (side > kMost) throw InputError("is too large");
    count *= side;
    if (count > kMost) throw InputError("is too large");
  }
  return count;
}

// Refuses `count` elements of a type where they are more than the stored bytes
// may stand for.
void CheckHeld(size_t count, hid_t type, hsize_t stored_bytes) {
  const hsize_t size = H5Tget_size(type);
  if (size != 0 && count <= MostUnpackedBytes(stored_bytes) / size) return;
  throw InputError("has " + std::to_string(count) + " entries, but only " +
                   std::to_string(stored_bytes) +
                   " bytes are stored of them, too few for a recording");
}

// Elements of a data set, all of which the file itself holds.
size_t HeldCount(hid_t file, const DataSet& of) {
  const hid_t set = of.set.get();
  const hid_t type = of.type.get();
  const Handle settings(H5Dget_create_plist(set), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(settings.get());
  if ((layout != H5D_COMPACT && layout != H5D_CONTIGUOUS &&
       layout != H5D_CHUNKED) ||
      H5Pget_external_count(settings.get()) != 0) {
    throw InputError("is damaged, or lies in other files");
  }
  hsize_t file_bytes = 0;
  H5Fget_filesize(file, &file_bytes);
  const hsize_t stored = std::min(H5Dget_storage_size(set), file_bytes);
  const size_t count = CountOf(ShapeOf(of.space.get()));
  CheckHeld(count, type, stored);
  // In one piece; in the file's own types, so texts of variable length aside.
  if (layout != H5D_CHUNKED && H5Tis_variable_str(type) <= 0 &&
      stored != count * H5Tget_size(type) &&
      (layout == H5D_COMPACT || stored != 0)) {
    throw InputError("is damaged");
  }
  if (layout == H5D_CHUNKED) {  // which the library unpacks as a whole
    std::vector<hsize_t> sides(H5S_MAX_RANK);
    const int rank = H5Pget_chunk(settings.get(), H5S_MAX_RANK, sides.data());
    if (rank < 0) throw InputError("is damaged");
    CheckHeld(CountOf({sides.begin(), sides.begin() + rank}), type, file_bytes);
  }
  return count;
}

// Reads `count` numbers, which lie in memory as `memory_type` says.
std::vector<double> NumbersOf(const DataSet& of, hid_t memory_type,
                              size_t count) {
  std::vector<double> numbers(count);
  if (!numbers.empty() && H5Dread(of.set.get(), memory_type, H5S_ALL, H5S_ALL,
                                  H5P_DEFAULT, numbers.data()) < 0) {
    throw InputError(kUnreadable);
  }
  return numbers;
}

// Numbers of one field of `of`, a data set of records; `*width` in each.
std::vector<double> FieldOf(hid_t file, const DataSet& of,
                            const std::string& field, size_t* width) {
  const hid_t type = of.type.get();
  const int place = H5Tget_class(type) == H5T_COMPOUND
                        ? H5Tget_member_index(type, field.c_str())
                        : -1;
  if (place < 0) throw InputError("has no field " + field);
  if (!HoldsItsFields(type)) throw InputError("is damaged");
  const Handle member(H5Tget_member_type(type, static_cast<unsigned>(place)),
                      H5Tclose);
  const bool is_array = H5Tget_class(member.get()) == H5T_ARRAY;
  const Handle element(
      is_array ? H5Tget_super(member.get()) : H5Tcopy(member.get()), H5Tclose);
  if (!IsPlainNumber(element.get()) ||
      (is_array && H5Tget_array_ndims(member.get()) != 1)) {
    throw InputError("field " + field + ": expected numbers");
  }
  hsize_t side = 1;
  if (is_array) H5Tget_array_dims2(member.get(), &side);
  if (H5Tget_size(member.get()) / H5Tget_size(element.get()) != side) {
    throw InputError("field " + field + ": is damaged");
  }
  *width = side;
  const Handle numbers(is_array ? H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &side)
                                : H5Tcopy(H5T_NATIVE_DOUBLE),
                       H5Tclose);
  const Handle record(H5Tcreate(H5T_COMPOUND, side * sizeof(double)), H5Tclose);
  H5Tinsert(record.get(), field.c_str(), 0, numbers.get());
  return NumbersOf(of, record.get(), CountOf({HeldCount(file, of), side}));
}

// Reads `count` texts of a type by `read`, which fills a buffer.
std::vector<std::string> TextsOf(
    hid_t type, hid_t space, size_t count,
    const std::function<herr_t(hid_t memory_type, void* to)>& read) {
  if (H5Tget_class(type) != H5T_STRING) throw InputError("expected texts");
  std::vector<std::string> texts(count);
  if (count == 0) return texts;
  const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_cset(memory.get(), H5Tget_cset(type));
  if (H5Tis_variable_str(type) > 0) {
    H5Tset_size(memory.get(), H5T_VARIABLE);
    std::vector<char*> words(count, nullptr);
    const bool is_read = read(memory.get(), words.data()) >= 0;
    for (size_t i = 0; i < count; ++i) {
      if (words[i] != nullptr) texts[i] = words[i];
    }
    H5Dvlen_reclaim(memory.get(), space, H5P_DEFAULT, words.data());
    if (!is_read) throw InputError(kUnreadable);
    return texts;
  }
  constexpr size_t kLongest = 1 << 20;
  const size_t width = H5Tget_size(type);
  if (width == 0 || width > kLongest) throw InputError("is damaged");
  H5Tset_size(memory.get(), width + 1);  // with the zero at the end
  std::vector<char> bytes(count * (width + 1));
  if (read(memory.get(), bytes.data()) < 0) throw InputError(kUnreadable);
  for (size_t i = 0; i < count; ++i) texts[i] = &bytes[i * (width + 1)];
  return texts;
}

}  // namespace

Hdf5File::Hdf5File(const std::string& path) : path_(path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // it prints otherwise
  if (IsFile(path)) file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ >= 0) return;
  throw InputError(
      path, "",
      IsFile(path) ? "is no HDF5 file, or damaged" : "cannot be read");
}

Hdf5File::~Hdf5File() { H5Fclose(file_); }

bool Hdf5File::Has(const std::string& name) const {
  return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5File::Names() const {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*,
                      void* to) -> herr_t {
    static_cast<std::vector<std::string>*>(to)->push_back(name);
    return 0;
  };
  if (H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) < 0) {
    throw InputError(path_, "", "is damaged");
  }
  return names;
}

std::vector<size_t> Hdf5File::Shape(const std::string& name) const {
  return ReadSet(path_, file_, name, name,
                 [](const DataSet& of) { return ShapeOf(of.space.get()); });
}

std::vector<double> Hdf5File::Numbers(const std::string& name) const {
  return ReadSet(path_, file_, name, name, [this](const DataSet& of) {
    if (!IsPlainNumber(of.type.get())) throw InputError("expected numbers");
    return NumbersOf(of, H5T_NATIVE_DOUBLE, HeldCount(file_, of));
  });
}

std::vector<std::string> Hdf5File::Texts(const std::string& name) const {
  return ReadSet(path_, file_, name, name, [this](const DataSet& of) {
    const auto read = [&of](hid_t memory_type, void* to) {
      // Several may be one text of the file.
      hsize_t bytes = 0;
      if (H5Tis_variable_str(memory_type) > 0 &&
          H5Dvlen_get_buf_size(of.set.get(), memory_type, of.space.get(),
                               &bytes) >= 0 &&
          bytes > kMaxSmallFileBytes) {
        throw InputError("is too large");
      }
      return H5Dread(of.set.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                     to);
    };
    return TextsOf(of.type.get(), of.space.get(), HeldCount(file_, of), read);
  });
}

std::vector<double> Hdf5File::Field(const std::string& name,
                                    const std::string& field,
                                    size_t* width) const {
  return ReadSet(path_, file_, name, name, [&](const DataSet& of) {
    return FieldOf(file_, of, field, width);
  });
}

std::string Hdf5File::Attribute(const std::string& name,
                                const std::string& attribute) const {
  const std::string label = name + "." + attribute;
  return ReadSet(path_, file_, name, label, [&](const DataSet& of) {
    if (H5Aexists(of.set.get(), attribute.c_str()) <= 0) return std::string();
    const Handle value(H5Aopen(of.set.get(), attribute.c_str(), H5P_DEFAULT),
                       H5Aclose);
    const Handle space(H5Aget_space(value.get()), H5Sclose);
    const Handle type(H5Aget_type(value.get()), H5Tclose);
    const size_t count = CountOf(ShapeOf(space.get()));
    if (count > 1) throw InputError("expected one text");
    const std::vector<std::string> texts = TextsOf(
        type.get(), space.get(), count, [&](hid_t memory_type, void* to) {
          return H5Aread(value.get(), memory_type, to);
        });
    return texts.empty() ? std::string() : texts.front();
  });
}

bool IsHdf5(const std::string& path) {
  return BeginningOf(path, 4) == "\x89HDF";
}

std::vector<std::string> Hdf5Names(const std::string& path) {
  std::vector<std::string> names;
  ReadHdf5(path, [&](const Hdf5File& file) { names = file.Names(); });
  return names;
}

void ReadHdf5(const std::string& path,
              const std::function<void(const Hdf5File& file)>& read) {
  const auto read_once = [&] {
    const Hdf5File file(path);
    read(file);
  };
  const auto status = StatusOf(path);
  // A minute, and a second a megabyte: fifty times what reading takes.
  const int64_t bytes = status.has_value() ? status->size : 0;
  const int limit_s =
      60 + static_cast<int>(std::min(bytes, int64_t{1} << 40) >> 20);
  // Nor is a process made while another thread is within the library.
  static std::mutex one_at_a_time;
  const std::lock_guard<std::mutex> alone(one_at_a_time);
  const ProcessEnd end = Rehearse(read_once, limit_s);
  if (end.not_started == 0 && !end.well()) {
    throw InputError(path, "",
                     "cannot be read by HDF5's library: it is damaged, or too "
                     "large for the memory");
  }
  read_once();
}

}  // namespace kinegraph

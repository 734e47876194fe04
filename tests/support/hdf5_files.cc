#include "tests/support/hdf5_files.h"

#include <hdf5.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <numeric>

namespace kinegraph::testing {
namespace {

// What the library answers where it did as it was asked.
hid_t Done(hid_t answer) {
  if (answer < 0) std::abort();
  return answer;
}

// A file that is in memory alone. Handles within it close with it.
class MemoryHdf5 {
 public:
  MemoryHdf5() {
    const hid_t access = Done(H5Pcreate(H5P_FILE_ACCESS));
    Done(H5Pset_fapl_core(access, 1 << 16, 0));
    Done(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG));
    file_ = Done(
        H5Fcreate("kinegraph_test.h5", H5F_ACC_TRUNC, H5P_DEFAULT, access));
    H5Pclose(access);
  }
  ~MemoryHdf5() { H5Fclose(file_); }
  MemoryHdf5(const MemoryHdf5&) = delete;
  MemoryHdf5& operator=(const MemoryHdf5&) = delete;

  hid_t file() const { return file_; }

  // Without numbers it is in chunks, none of which is there.
  hid_t Set(const std::string& name, hid_t type,
            const std::vector<uint64_t>& sides, const void* numbers) {
    const std::vector<hsize_t> extent(sides.begin(), sides.end());
    const auto rank = static_cast<int>(extent.size());
    const hid_t layout = Done(H5Pcreate(H5P_DATASET_CREATE));
    if (numbers == nullptr) {
      std::vector<hsize_t> chunk(extent.size());
      std::transform(
          extent.begin(), extent.end(), chunk.begin(),
          [](hsize_t side) { return std::clamp<hsize_t>(side, 1, 8); });
      Done(H5Pset_chunk(layout, rank, chunk.data()));
    }
    const hid_t set =
        Done(H5Dcreate2(file_, name.c_str(), type,
                        Done(H5Screate_simple(rank, extent.data(), nullptr)),
                        H5P_DEFAULT, layout, H5P_DEFAULT));
    if (numbers != nullptr) {
      Done(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers));
    }
    return set;
  }

  static void Attribute(hid_t set, const std::string& name,
                        const std::string& text) {
    const hid_t type = TextType(text.size() + 1);
    Done(H5Awrite(
        Done(H5Acreate2(set, name.c_str(), type, Done(H5Screate(H5S_SCALAR)),
                        H5P_DEFAULT, H5P_DEFAULT)),
        type, text.c_str()));
  }

  static hid_t TextType(size_t bytes) {
    const hid_t type = Done(H5Tcopy(H5T_C_S1));
    Done(H5Tset_size(type, bytes));
    return type;
  }

  std::string Bytes() {
    Done(H5Fflush(file_, H5F_SCOPE_LOCAL));
    const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
    std::string bytes(static_cast<size_t>(Done(size)), '\0');
    Done(H5Fget_file_image(file_, bytes.data(), bytes.size()));
    return bytes;
  }

 private:
  hid_t file_ = -1;
};

std::vector<double> Counting(size_t count) {
  std::vector<double> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 10.0);
  return numbers;
}

}  // namespace

std::string SleapHdf5(const SleapFile& content) {
  MemoryHdf5 made;
  std::vector<double> numbers;
  if (content.has_numbers) {
    numbers =
        Counting(std::accumulate(content.sides.begin(), content.sides.end(),
                                 size_t{1}, std::multiplies<>()));
  }
  const hid_t tracks = made.Set("tracks", H5T_NATIVE_DOUBLE, content.sides,
                                content.has_numbers ? numbers.data() : nullptr);
  std::string dims;
  for (const std::string& axis : content.axes) {
    dims += (dims.empty() ? "[\"" : ", \"") + axis + "\"";
  }
  MemoryHdf5::Attribute(tracks, "dims", dims + "]");
  const double zero = 0.0;
  for (int i = 0; i < content.other_sets; ++i) {
    made.Set("a_set_of_another_name_" + std::to_string(i), H5T_NATIVE_DOUBLE,
             {1}, &zero);
  }
  if (content.claimed_nodes > 0) {
    made.Set("node_names", MemoryHdf5::TextType(1000), {content.claimed_nodes},
             nullptr);
  } else {
    constexpr size_t kWidth = 12;
    std::string names;
    for (std::string name : content.nodes) {
      name.resize(kWidth);
      names += name;
    }
    made.Set("node_names", MemoryHdf5::TextType(kWidth), {content.nodes.size()},
             names.data());
  }
  made.Set("edge_inds", H5T_NATIVE_INT64, content.edge_sides,
           content.edges.data());
  return made.Bytes();
}

std::string DeepLabCutHdf5(const DeepLabCutFile& content) {
  MemoryHdf5 made;
  constexpr uint64_t kFrames = 3;
  Done(H5Gcreate2(made.file(), "df_with_missing", H5P_DEFAULT, H5P_DEFAULT,
                  H5P_DEFAULT));
  // Records of a frame's number and its numbers, all of them doubles here,
  // which the reader makes of them anyway.
  const hsize_t side = content.width;
  const size_t record_bytes = sizeof(double) * (1 + content.width);
  const hid_t record = Done(H5Tcreate(H5T_COMPOUND, record_bytes));
  Done(H5Tinsert(record, "index", 0, H5T_NATIVE_DOUBLE));
  Done(H5Tinsert(record, "values_block_0", sizeof(double),
                 Done(H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &side))));
  const std::vector<double> numbers = Counting(kFrames * (1 + content.width));
  const hid_t table =
      made.Set("df_with_missing/table", record, {kFrames}, numbers.data());
  MemoryHdf5::Attribute(table, "index_kind", "integer");
  MemoryHdf5::Attribute(table, "values_block_0_kind",
                        !content.pickled.empty()
                            ? content.pickled
                            : "(lp0\n(Vnet\np1\nVtail\np2\nVx\np3\ntp4\na"
                              "(g1\ng2\nVy\np5\ntp6\na"
                              "(g1\ng2\nVlikelihood\np7\ntp8\na.");
  return made.Bytes();
}

}  // namespace kinegraph::testing

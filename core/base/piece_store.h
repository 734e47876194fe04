// Where results of dear pieces of work are kept, so that a run that was ended
// goes on. Safe in threads.
#ifndef KINEGRAPH_CORE_BASE_PIECE_STORE_H_
#define KINEGRAPH_CORE_BASE_PIECE_STORE_H_

#include <optional>
#include <string>

namespace kinegraph {

class PieceStore {
 public:
  virtual ~PieceStore() = default;

  // A piece is known by the fingerprint (core/base/bytes.h) of everything that
  // its result depends on but the build.
  virtual std::optional<std::string> Find(const std::string& key) = 0;
  virtual void Add(const std::string& key, std::string value) = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_PIECE_STORE_H_

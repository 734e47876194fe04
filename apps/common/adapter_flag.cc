#include "apps/common/adapter_flag.h"

#include <gflags/gflags.h>

#include "apps/common/app.h"
#include "core/io/adapters/adapter.h"
#include "core/io/files/text_file.h"

DEFINE_string(adapter, "",
              "your program that reads an unsupported format and prints "
              "kinegraph's (docs/adapters.md); tried before all built-in "
              "formats");

namespace kinegraph {

void UseAdapterFlag() {
  if (!FLAGS_adapter.empty() && !IsFile(FLAGS_adapter)) {
    FailFlag("adapter", FLAGS_adapter, "an executable file");
  }
  SetAdapter(FLAGS_adapter);
}

}  // namespace kinegraph

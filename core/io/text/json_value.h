// The JSON classes, which json.h only declares, for sources that store a value.
#ifndef KINEGRAPH_CORE_IO_TEXT_JSON_VALUE_H_
#define KINEGRAPH_CORE_IO_TEXT_JSON_VALUE_H_

#include <nlohmann/json.hpp>

#include "core/io/text/json.h"

#endif  // KINEGRAPH_CORE_IO_TEXT_JSON_VALUE_H_

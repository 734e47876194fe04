// Decodes Base64 (RFC 4648).
#ifndef KINEGRAPH_TESTS_SUPPORT_BASE64_H_
#define KINEGRAPH_TESTS_SUPPORT_BASE64_H_

#include <string>

namespace kinegraph::testing {

std::string FromBase64(const std::string& text);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_BASE64_H_

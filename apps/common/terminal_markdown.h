// Text for a terminal of so many columns. Counts characters, not bytes.
#ifndef KINEGRAPH_APPS_COMMON_TERMINAL_MARKDOWN_H_
#define KINEGRAPH_APPS_COMMON_TERMINAL_MARKDOWN_H_

#include <cstddef>
#include <string>

namespace kinegraph {

// Paragraphs wrap at spaces. Tables are lined up; one that is too wide loses
// what its cells have in brackets, then letters of its first column, then
// columns from the right, and a line says that `where` has them.
std::string ForTerminal(const std::string& markdown, size_t columns,
                        const std::string& where);

// Lines of at most `columns`, broken where there is white space; all but the
// first begin with `indent`. A single word may be longer than a line.
std::string Wrapped(const std::string& text, size_t columns,
                    const std::string& indent = "");

// At most `letters`, the last one a "~" where something is missing.
std::string Cut(const std::string& text, size_t letters);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TERMINAL_MARKDOWN_H_

// Markdown for a terminal of so many columns.
#ifndef KINEGRAPH_APPS_COMMON_TERMINAL_MARKDOWN_H_
#define KINEGRAPH_APPS_COMMON_TERMINAL_MARKDOWN_H_

#include <cstddef>
#include <string>

namespace kinegraph {

// Paragraphs wrap at spaces. Tables are lined up; one that is too wide loses
// what its cells have in brackets, then letters of its first column, then
// columns from the right, and a line says that `where` has them. Counts
// characters, not bytes; a single word may still be longer than a line.
std::string ForTerminal(const std::string& markdown, size_t columns,
                        const std::string& where);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TERMINAL_MARKDOWN_H_

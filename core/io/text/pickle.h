// Python's pickles of numbers, texts, lists, dictionaries and NumPy arrays. For
// core/io alone.
#ifndef KINEGRAPH_CORE_IO_TEXT_PICKLE_H_
#define KINEGRAPH_CORE_IO_TEXT_PICKLE_H_

#include <string>

#include "core/io/text/json.h"

namespace kinegraph {

// Whether bytes begin as a pickle of protocol 2 or later does.
bool IsPickle(const std::string& bytes);

// The value of a pickle (protocols 2 to 5), an array as rows of rows. A pickle
// is a program: of its instructions only those are followed that build such
// values, and of the functions that it may call only the four with which
// Python and NumPy store an array. Anything else is refused by its name;
// nothing is executed. Throws InputError naming `file`.
Json ParsePickle(const std::string& bytes, const std::string& file);
// The same of protocol 0, which has no mark to know it by.
Json ParseTextPickle(const std::string& bytes, const std::string& file);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_PICKLE_H_

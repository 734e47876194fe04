#include "core/io/text/xml_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/text/words.h"

namespace kinegraph {

struct XmlElement::Document {
  std::string text;
  std::string file;
  pugi::xml_document tree;

  // Counts newline bytes before the offset, which is correct for UTF-8. In
  // other encodings the line is too small, since pugixml counts the offset in
  // the text that it has converted to UTF-8.
  std::string LineAt(ptrdiff_t offset) const {
    const auto end =
        text.begin() +
        std::clamp<ptrdiff_t>(offset, 0, static_cast<ptrdiff_t>(text.size()));
    return "line " + std::to_string(1 + std::count(text.begin(), end, '\n'));
  }
};

const std::string& XmlElement::file() const { return document_->file; }

void XmlElement::Fail(const std::string& message) const {
  throw InputError(document_->file, document_->LineAt(node_.offset_debug()),
                   message);
}

std::vector<XmlElement> XmlElement::All(const std::string& name) const {
  std::vector<XmlElement> elements;
  for (const pugi::xml_node child : node_.children(name.c_str())) {
    elements.push_back(XmlElement(document_, child));
  }
  return elements;
}

std::optional<XmlElement> XmlElement::Find(const std::string& name) const {
  const pugi::xml_node child = node_.child(name.c_str());
  if (!child) return std::nullopt;
  return XmlElement(document_, child);
}

XmlElement XmlElement::At(const std::string& name) const {
  if (auto element = Find(name)) return *std::move(element);
  Fail("<" + Printable(this->name()) + "> has no element <" + name + ">");
}

std::optional<std::string> XmlElement::FindText(
    const std::string& attribute) const {
  const pugi::xml_attribute found = node_.attribute(attribute.c_str());
  if (!found) return std::nullopt;
  return std::string(found.value());
}

std::string XmlElement::Text(const std::string& attribute) const {
  if (auto text = FindText(attribute)) return *std::move(text);
  Fail("<" + Printable(name()) + "> has no attribute " + attribute);
}

double XmlElement::Number(const std::string& attribute) const {
  return ToNumber(attribute, Text(attribute));
}

double XmlElement::NumberOr(const std::string& attribute,
                            double otherwise) const {
  return FindText(attribute).has_value() ? Number(attribute) : otherwise;
}

double XmlElement::ToNumber(const std::string& attribute,
                            const std::string& word) const {
  const auto number = ParseNumber<double>(WithoutPlus(word));
  if (number.has_value() && std::isfinite(*number)) return *number;
  Fail(attribute + ": found '" + Printable(word) +
       "', expected a finite number");
}

std::vector<double> XmlElement::Numbers(const std::string& attribute,
                                        size_t count) const {
  const std::string text = Text(attribute);
  Words words(text);
  std::vector<double> numbers;
  std::string word(words.Next());
  if (word.find_first_of("0123456789+-.") != 0) word = words.Next();  // a name
  for (; !word.empty() && numbers.size() <= count; word = words.Next()) {
    numbers.push_back(ToNumber(attribute, word));
  }
  if (numbers.size() != count) {
    Fail(attribute + ": found " +
         (numbers.size() > count ? "more than " + std::to_string(count)
                                 : std::to_string(numbers.size())) +
         " numbers, expected " + std::to_string(count));
  }
  return numbers;
}

XmlElement ParseXml(std::string text, const std::string& file) {
  // Far more than the cameras of a laboratory need. Elements take more memory
  // than their text.
  constexpr size_t kMaxBytes = size_t{16} << 20;
  if (text.size() > kMaxBytes) {
    throw InputError(file, "", "is larger than 16 MiB, the limit for XML");
  }
  auto document = std::make_shared<XmlElement::Document>();
  document->text = std::move(text);
  document->file = file;
  const pugi::xml_parse_result result =
      document->tree.load_buffer(document->text.data(), document->text.size());
  const pugi::xml_node root = document->tree.document_element();
  if (!result || !root) {
    throw InputError(file, document->LineAt(result.offset),
                     std::string("is not XML: ") +
                         (result ? "has no element" : result.description()));
  }
  return XmlElement(std::move(document), root);
}

}  // namespace kinegraph

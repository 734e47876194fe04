// XML calibrations written by motion capture systems. For the readers of
// core/io only.
#ifndef KINEGRAPH_CORE_IO_TEXT_XML_FILE_H_
#define KINEGRAPH_CORE_IO_TEXT_XML_FILE_H_

#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <vector>

namespace kinegraph {

// An element, with its file and line for messages. Keeps the whole document
// alive.
class XmlElement {
 public:
  const std::string& file() const;
  std::string name() const { return node_.name(); }

  // Throws InputError "file: line 12: message".
  [[noreturn]] void Fail(const std::string& message) const;

  // Child elements in file order. Find returns the first or nullopt, At throws
  // InputError if there is none.
  std::vector<XmlElement> All(const std::string& name) const;
  std::optional<XmlElement> Find(const std::string& name) const;
  XmlElement At(const std::string& name) const;

  // Attributes. Text, Number and Numbers throw InputError if the attribute is
  // absent; Number, NumberOr and Numbers throw it for anything but finite
  // numbers. Numbers() requires exactly `count` numbers separated by spaces and
  // skips a leading name (Vicon's "ViconRadial2 0 0 ...").
  std::optional<std::string> FindText(const std::string& attribute) const;
  std::string Text(const std::string& attribute) const;
  double Number(const std::string& attribute) const;
  double NumberOr(const std::string& attribute, double otherwise) const;
  std::vector<double> Numbers(const std::string& attribute, size_t count) const;

 private:
  struct Document;
  friend XmlElement ParseXml(std::string text, const std::string& file);
  XmlElement(std::shared_ptr<const Document> document, pugi::xml_node node)
      : document_(std::move(document)), node_(node) {}
  double ToNumber(const std::string& attribute, const std::string& word) const;

  std::shared_ptr<const Document> document_;
  pugi::xml_node node_;
};

// Parses a text in UTF-8, UTF-16 or UTF-32; returns the root element. Only
// XML's own five entities and character references (&#65;) are replaced, and
// nothing external is read. Throws InputError naming `file` for more than 16
// MiB, and with the line for a syntax error.
XmlElement ParseXml(std::string text, const std::string& file);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_XML_FILE_H_

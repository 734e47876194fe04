#include "core/io/text/pickle.h"

#include <charconv>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// A calibration has a few hundred values; references can repeat a value many
// times, so what comes out is bounded, too.
constexpr size_t kMaxPickled = 200'000;

enum class Kind {
  kMark,
  kNone,
  kBoolean,
  kInteger,
  kNumber,
  kText,
  kBytes,
  kTuple,
  kList,
  kDict,    // items are key, value, key, value, ...
  kGlobal,  // text is "module.name"
  kDtype,   // text is "<f8"
  kArray,   // items are the elements in the order of rows; shape
};

struct Value {
  Kind kind = Kind::kNone;
  int64_t integer = 0;
  double number = 0.0;
  std::string text;
  std::vector<Value*> items;
  std::vector<size_t> shape;
  std::vector<double> elements;
};

// NumPy's modules are numpy.core before version 2, numpy._core since.
bool IsNumPy(const std::string& name, const std::string& function) {
  return name == "numpy.core." + function || name == "numpy._core." + function;
}

template <typename Number>
double Load(const char* from, bool big_endian) {
  char bytes[sizeof(Number)];
  std::memcpy(bytes, from, sizeof bytes);
  if (big_endian) {
    for (size_t i = 0; 2 * i + 1 < sizeof bytes; ++i) {
      std::swap(bytes[i], bytes[sizeof bytes - 1 - i]);
    }
  }
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

using LoadElement = double (*)(const char* from, bool big_endian);

// Of a dtype without byte order, "f8"; nullptr for one that holds no numbers.
LoadElement ElementOf(const std::string& type) {
  static const std::unordered_map<std::string, LoadElement> kTypes = {
      {"f4", Load<float>},    {"f8", Load<double>},   {"i1", Load<int8_t>},
      {"i2", Load<int16_t>},  {"i4", Load<int32_t>},  {"i8", Load<int64_t>},
      {"u1", Load<uint8_t>},  {"u2", Load<uint16_t>}, {"u4", Load<uint32_t>},
      {"u8", Load<uint64_t>}, {"b1", Load<uint8_t>}};
  const auto at = kTypes.find(type);
  return at == kTypes.end() ? nullptr : at->second;
}

// The machine that a pickle is a program of, with the few instructions that
// build values. Values live in a store of their own, as they may refer to each
// other in circles.
class PickleReader {
 public:
  PickleReader(const std::string& bytes, const std::string& file)
      : bytes_(bytes), file_(file) {}

  Json Read() {
    while (true) {
      const size_t place = at_;
      const auto code = static_cast<unsigned char>(Take(1)[0]);
      if (code == '.') break;
      if (!Build(code) && !BuildNumber(code) && !BuildText(code) &&
          !Remember(code)) {
        Fail("byte " + std::to_string(place) + ": found the instruction " +
             std::to_string(code) +
             ", which no pickle of numbers and NumPy arrays needs");
      }
    }
    size_t budget = kMaxPickled;
    return ToJson(*Pop(), 0, &budget);
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(file_, "pickle", message);
  }

  // ---- Bytes ----

  const char* Take(size_t count) {
    if (count > bytes_.size() - at_) Fail("ends too early");
    const char* from = bytes_.data() + at_;
    at_ += count;
    return from;
  }

  // Little-endian, without sign.
  uint64_t ReadCount(size_t width) {
    const char* from = Take(width);
    uint64_t count = 0;
    for (size_t i = 0; i < width; ++i) {
      count |= uint64_t{static_cast<unsigned char>(from[i])} << (8 * i);
    }
    return count;
  }

  std::string ReadBytes(uint64_t count) {
    if (count > bytes_.size() - at_) Fail("ends too early");
    return std::string(Take(count), count);
  }

  std::string ReadLine() {
    const size_t end = bytes_.find('\n', at_);
    if (end == std::string::npos) Fail("ends too early");
    std::string line = ReadBytes(end - at_);
    Take(1);
    return line;
  }

  uint64_t ReadNumberLine() {
    const std::string line = ReadLine();
    uint64_t number = 0;
    const char* end = line.data() + line.size();
    const auto [stop, error] = std::from_chars(line.data(), end, number);
    if (error != std::errc() || stop != end) Fail("refers to no number");
    return number;
  }

  // ---- The stack ----

  Value* Push(Kind kind) {
    if (values_.size() >= kMaxPickled) Fail("has too many values");
    values_.emplace_back();
    values_.back().kind = kind;
    stack_.push_back(&values_.back());
    return stack_.back();
  }
  void PushText(Kind kind, std::string text) {
    Push(kind)->text = std::move(text);
  }

  Value* Pop() {
    if (stack_.empty()) Fail("takes more values than it has made");
    Value* value = stack_.back();
    stack_.pop_back();
    return value;
  }
  Value* Pop(Kind kind, const char* what) {
    Value* value = Pop();
    if (value->kind != kind) Fail(std::string("expected ") + what);
    return value;
  }

  std::vector<Value*> PopToMark() {
    std::vector<Value*> items;
    while (true) {
      Value* value = Pop();
      if (value->kind == Kind::kMark) break;
      items.push_back(value);
    }
    return {items.rbegin(), items.rend()};
  }

  void PushItems(Kind kind, std::vector<Value*> items) {
    if (kind == Kind::kDict && items.size() % 2 != 0)
      Fail("a key lacks a value");
    Push(kind)->items = std::move(items);
  }

  // Adds to the list or dictionary on the stack.
  void Append(Kind kind, const std::vector<Value*>& items) {
    Value* whole = Pop(kind, kind == Kind::kList ? "a list" : "a dictionary");
    if (kind == Kind::kDict && items.size() % 2 != 0)
      Fail("a key lacks a value");
    whole->items.insert(whole->items.end(), items.begin(), items.end());
    stack_.push_back(whole);
  }

  std::vector<Value*> PopMany(size_t count) {
    std::vector<Value*> items(count);
    for (size_t i = count; i-- > 0;) items[i] = Pop();
    return items;
  }

  // ---- Instructions (Python's pickletools names them) ----

  bool Build(unsigned char code) {
    switch (code) {
      case 0x80:  // PROTO
        ReadCount(1);
        return true;
      case 0x95:  // FRAME
        ReadCount(8);
        return true;
      case '(':
        Push(Kind::kMark);
        return true;
      case '0':  // POP
        Pop();
        return true;
      case '1':  // POP_MARK
        PopToMark();
        return true;
      case ')':
        PushItems(Kind::kTuple, {});
        return true;
      case 0x85:  // TUPLE1 .. TUPLE3
      case 0x86:
      case 0x87:
        PushItems(Kind::kTuple, PopMany(code - 0x84));
        return true;
      case 't':
        PushItems(Kind::kTuple, PopToMark());
        return true;
      case ']':
        PushItems(Kind::kList, {});
        return true;
      case 'l':
        PushItems(Kind::kList, PopToMark());
        return true;
      case '}':
        PushItems(Kind::kDict, {});
        return true;
      case 'd':
        PushItems(Kind::kDict, PopToMark());
        return true;
      default:
        return Fill(code);
    }
  }

  bool Fill(unsigned char code) {
    switch (code) {
      case 'a':  // APPEND
        Append(Kind::kList, PopMany(1));
        return true;
      case 'e':  // APPENDS
        Append(Kind::kList, PopToMark());
        return true;
      case 's':  // SETITEM
        Append(Kind::kDict, PopMany(2));
        return true;
      case 'u':  // SETITEMS
        Append(Kind::kDict, PopToMark());
        return true;
      case 'c': {  // GLOBAL
        const std::string module = ReadLine();
        PushText(Kind::kGlobal, module + "." + ReadLine());
        return true;
      }
      case 0x93: {  // STACK_GLOBAL
        const std::string name = Pop(Kind::kText, "a text")->text;
        PushText(Kind::kGlobal, Pop(Kind::kText, "a text")->text + "." + name);
        return true;
      }
      case 'R': {  // REDUCE
        const Value* arguments = Pop(Kind::kTuple, "a tuple");
        Call(Pop(Kind::kGlobal, "a name")->text, arguments->items);
        return true;
      }
      case 'b': {  // BUILD
        const Value* state = Pop(Kind::kTuple, "a tuple");
        SetState(Pop(), state->items);
        return true;
      }
      default:
        return false;
    }
  }

  bool BuildNumber(unsigned char code) {
    switch (code) {
      case 'N':
        Push(Kind::kNone);
        return true;
      case 0x88:  // NEWTRUE
      case 0x89:  // NEWFALSE
        Push(Kind::kBoolean)->integer = code == 0x88 ? 1 : 0;
        return true;
      case 'K':  // BININT1
        Push(Kind::kInteger)->integer = static_cast<int64_t>(ReadCount(1));
        return true;
      case 'M':  // BININT2
        Push(Kind::kInteger)->integer = static_cast<int64_t>(ReadCount(2));
        return true;
      case 'J':  // BININT
        Push(Kind::kInteger)->integer = static_cast<int32_t>(ReadCount(4));
        return true;
      case 0x8a: {  // LONG1
        const size_t width = ReadCount(1);
        if (width > 8) Fail("has an integer of more than 64 bits");
        uint64_t bits = ReadCount(width);
        const bool negative = width > 0 && ((bits >> (8 * width - 1)) & 1) != 0;
        if (negative && width < 8) bits |= ~uint64_t{0} << (8 * width);
        Push(Kind::kInteger)->integer = static_cast<int64_t>(bits);
        return true;
      }
      case 'G':  // BINFLOAT, the one that is big-endian
        Push(Kind::kNumber)->number = Load<double>(Take(8), true);
        return true;
      default:
        return false;
    }
  }

  bool BuildText(unsigned char code) {
    switch (code) {
      case 0x8c:  // SHORT_BINUNICODE
        PushText(Kind::kText, ReadBytes(ReadCount(1)));
        return true;
      case 'X':  // BINUNICODE
        PushText(Kind::kText, ReadBytes(ReadCount(4)));
        return true;
      case 0x8d:  // BINUNICODE8
        PushText(Kind::kText, ReadBytes(ReadCount(8)));
        return true;
      case 'V':  // UNICODE, of protocol 0
        PushText(Kind::kText, ReadLine());
        return true;
      // Python 2's texts are bytes.
      case 'U':  // SHORT_BINSTRING
        PushText(Kind::kText, ReadBytes(ReadCount(1)));
        return true;
      case 'T':  // BINSTRING
        PushText(Kind::kText, ReadBytes(ReadCount(4)));
        return true;
      case 'C':  // SHORT_BINBYTES
        PushText(Kind::kBytes, ReadBytes(ReadCount(1)));
        return true;
      case 'B':  // BINBYTES
        PushText(Kind::kBytes, ReadBytes(ReadCount(4)));
        return true;
      case 0x8e:  // BINBYTES8
      case 0x96:  // BYTEARRAY8
        PushText(Kind::kBytes, ReadBytes(ReadCount(8)));
        return true;
      default:
        return false;
    }
  }

  bool Remember(unsigned char code) {
    switch (code) {
      case 0x94:  // MEMOIZE
        memory_[memory_.size()] = Top();
        return true;
      case 'q':  // BINPUT
        memory_[ReadCount(1)] = Top();
        return true;
      case 'r':  // LONG_BINPUT
        memory_[ReadCount(4)] = Top();
        return true;
      case 'p':  // PUT and GET, of protocol 0
        memory_[ReadNumberLine()] = Top();
        return true;
      case 'g':
        Recall(ReadNumberLine());
        return true;
      case 'h':  // BINGET
        Recall(ReadCount(1));
        return true;
      case 'j':  // LONG_BINGET
        Recall(ReadCount(4));
        return true;
      default:
        return false;
    }
  }

  Value* Top() {
    if (stack_.empty()) Fail("takes more values than it has made");
    return stack_.back();
  }
  void Recall(uint64_t place) {
    const auto at = memory_.find(place);
    if (at == memory_.end()) Fail("refers to a value that it has not made");
    stack_.push_back(at->second);
  }

  // ---- What may be called ----

  void Call(const std::string& name, const std::vector<Value*>& arguments) {
    const size_t count = arguments.size();
    if (name == "numpy.dtype" && count >= 1 &&
        arguments[0]->kind == Kind::kText) {
      PushText(Kind::kDtype, arguments[0]->text);
    } else if (IsNumPy(name, "multiarray._reconstruct") && count == 3 &&
               arguments[0]->kind == Kind::kGlobal &&
               arguments[0]->text == "numpy.ndarray") {
      Push(Kind::kArray);
    } else if (IsNumPy(name, "multiarray.scalar") && count == 2) {
      FillArray(Push(Kind::kArray), {}, *arguments[0], *arguments[1], false);
    } else if (IsNumPy(name, "numeric._frombuffer") && count == 4) {
      FillArray(Push(Kind::kArray), ShapeOf(*arguments[2]), *arguments[1],
                *arguments[0], arguments[3]->text == "F");
    } else if (name == "_codecs.encode" && count == 2 &&
               arguments[0]->kind == Kind::kText) {
      PushText(Kind::kBytes, ToLatin1(arguments[0]->text));
    } else {
      Fail("calls '" + Printable(name) +
           "', which no pickle of numbers and NumPy arrays needs; nothing of "
           "it is executed");
    }
  }

  // Bytes that Python 3 keeps as a text for Python 2.
  std::string ToLatin1(const std::string& utf8) const {
    std::string bytes;
    for (size_t i = 0; i < utf8.size(); ++i) {
      const auto first = static_cast<unsigned char>(utf8[i]);
      if (first < 0x80) {
        bytes += utf8[i];
      } else if ((first == 0xc2 || first == 0xc3) && i + 1 < utf8.size()) {
        const auto second = static_cast<unsigned char>(utf8[++i]);
        bytes += static_cast<char>(((first & 3) << 6) | (second & 0x3f));
      } else {
        Fail("has a text that is no bytes");
      }
    }
    return bytes;
  }

  void SetState(Value* of, const std::vector<Value*>& state) {
    if (of->kind == Kind::kDtype && state.size() >= 2 &&
        state[1]->kind == Kind::kText) {
      // (version, byte order, fields, ...)
      of->text = state[1]->text + of->text;
    } else if (of->kind == Kind::kArray && state.size() == 5) {
      // (version, shape, dtype, whether columns come first, elements)
      FillArray(of, ShapeOf(*state[1]), *state[2], *state[4],
                state[3]->integer != 0);
    } else {
      Fail("sets the state of what is no NumPy array");
    }
    stack_.push_back(of);
  }

  std::vector<size_t> ShapeOf(const Value& value) const {
    std::vector<size_t> shape;
    if (value.kind != Kind::kTuple) Fail("an array's shape is no tuple");
    for (const Value* side : value.items) {
      if (side->kind != Kind::kInteger || side->integer < 0 ||
          side->integer > static_cast<int64_t>(kMaxPickled)) {
        Fail("an array's shape is no list of sizes");
      }
      shape.push_back(static_cast<size_t>(side->integer));
    }
    constexpr size_t kMaxAxes = 8;
    if (shape.size() > kMaxAxes) Fail("an array has too many axes");
    return shape;
  }

  void FillArray(Value* array, std::vector<size_t> shape, const Value& dtype,
                 const Value& data, bool columns_first) {
    if (dtype.kind != Kind::kDtype) Fail("an array has no type");
    const size_t name = dtype.text.find_first_not_of("<>=|");
    const std::string type =
        name == std::string::npos ? "" : dtype.text.substr(name);
    const LoadElement load = ElementOf(type);
    if (load == nullptr) {
      Fail("found an array of the type '" + Printable(dtype.text) +
           "', expected numbers");
    }
    const bool big_endian = dtype.text.front() == '>';
    if (data.kind != Kind::kBytes && data.kind != Kind::kText) {
      Fail("an array has no bytes");
    }
    const size_t width = static_cast<size_t>(type[1] - '0');
    size_t count = 1;
    for (const size_t side : shape) {
      count *= side;
      if (count > kMaxPickled) Fail("an array is too large");
    }
    if (data.text.size() != count * width) {
      Fail("an array of " + std::to_string(count) + " elements has " +
           std::to_string(data.text.size()) + " bytes, expected " +
           std::to_string(count * width));
    }
    array->shape = std::move(shape);
    array->elements.clear();
    for (size_t i = 0; i < count; ++i) {
      const size_t place = columns_first ? ColumnPlace(i, array->shape) : i;
      array->elements.push_back(
          load(data.text.data() + place * width, big_endian));
    }
  }

  // Where the element with this place among rows stands among columns.
  static size_t ColumnPlace(size_t place, const std::vector<size_t>& shape) {
    size_t among_columns = 0;
    size_t left = place;
    for (size_t axis = shape.size(); axis-- > 0;) {
      size_t step = 1;
      for (size_t before = 0; before < axis; ++before) step *= shape[before];
      among_columns += left % shape[axis] * step;
      left /= shape[axis];
    }
    return among_columns;
  }

  // ---- To JSON ----

  void Spend(size_t count, size_t* budget) const {
    if (count > *budget) Fail("has too many values");
    *budget -= count;
  }

  Json ArrayToJson(const Value& array, size_t axis, size_t* next) const {
    if (axis == array.shape.size()) return array.elements[(*next)++];
    Json rows = Json::array();
    for (size_t i = 0; i < array.shape[axis]; ++i) {
      rows.push_back(ArrayToJson(array, axis + 1, next));
    }
    return rows;
  }

  Json ToJson(const Value& value, int depth, size_t* budget) const {
    if (depth > kMaxJsonDepth) Fail("is nested too deeply");
    Spend(1 + value.elements.size(), budget);
    Json json;
    switch (value.kind) {
      case Kind::kNone:
        return json;
      case Kind::kBoolean:
        return value.integer != 0;
      case Kind::kInteger:
        return value.integer;
      case Kind::kNumber:
        return value.number;
      case Kind::kText:
        return value.text;
      case Kind::kArray: {
        size_t next = 0;
        for (const size_t side : value.shape) {
          if (side == 0) return Json::array();
        }
        if (value.elements.empty()) Fail("an array has no elements");
        return ArrayToJson(value, 0, &next);
      }
      case Kind::kTuple:
      case Kind::kList:
        json = Json::array();
        for (const Value* item : value.items) {
          json.push_back(ToJson(*item, depth + 1, budget));
        }
        return json;
      case Kind::kDict:
        json = Json::object();
        for (size_t i = 0; i < value.items.size(); i += 2) {
          if (value.items[i]->kind != Kind::kText) Fail("a key is no text");
          json[value.items[i]->text] =
              ToJson(*value.items[i + 1], depth + 1, budget);
        }
        if (json.size() > kMaxJsonKeys) Fail("has too many keys");
        return json;
      default:
        Fail("holds what is no number, text, list, dictionary or array");
    }
  }

  const std::string& bytes_;
  const std::string& file_;
  size_t at_ = 0;
  std::deque<Value> values_;
  std::vector<Value*> stack_;
  std::unordered_map<uint64_t, Value*> memory_;
};

}  // namespace

bool IsPickle(const std::string& bytes) {
  return bytes.size() > 2 && bytes[0] == '\x80' && bytes[1] >= 2 &&
         bytes[1] <= 5;
}

Json ParsePickle(const std::string& bytes, const std::string& file) {
  if (!IsPickle(bytes)) {
    throw InputError(file, "", "is no pickle of Python's protocols 2 to 5");
  }
  return PickleReader(bytes, file).Read();
}

Json ParseTextPickle(const std::string& bytes, const std::string& file) {
  return PickleReader(bytes, file).Read();
}

}  // namespace kinegraph

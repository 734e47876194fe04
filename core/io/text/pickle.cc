#include <algorithm>
#include <cstring>
#include <deque>
#include <iterator>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/text/json.h"

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

  Json Read();

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
    if (const auto number = ParseNumber<uint64_t>(ReadLine())) return *number;
    Fail("refers to no number");
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
  // Of a length of so many bytes, and then the text itself.
  void PushBytes(Kind kind, size_t width) {
    PushText(kind, ReadBytes(ReadCount(width)));
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

  void PushItems(Kind kind, const std::vector<Value*>& items) {
    Push(kind);
    Append(kind, items);
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

  // ---- Instructions ----

  struct Instruction {
    unsigned char code;
    void (*run)(PickleReader* reader);
  };
  static const Instruction kInstructions[];

  void PushInteger(int64_t integer) { Push(Kind::kInteger)->integer = integer; }
  void PushInteger(uint64_t integer) {
    PushInteger(static_cast<int64_t>(integer));
  }

  // Of up to eight bytes, with sign.
  int64_t ReadLong() {
    const size_t width = ReadCount(1);
    if (width > 8) Fail("has an integer of more than 64 bits");
    uint64_t bits = ReadCount(width);
    const bool negative = width > 0 && ((bits >> (8 * width - 1)) & 1) != 0;
    if (negative && width < 8) bits |= ~uint64_t{0} << (8 * width);
    return static_cast<int64_t>(bits);
  }

  void PushGlobal(const std::string& module, const std::string& name) {
    PushText(Kind::kGlobal, module + "." + name);
  }
  void PushGlobalLines() {
    const std::string module = ReadLine();
    PushGlobal(module, ReadLine());
  }
  void PushGlobalOfStack() {
    const std::string name = Pop(Kind::kText, "a text")->text;
    PushGlobal(Pop(Kind::kText, "a text")->text, name);
  }

  void Reduce() {
    const Value* arguments = Pop(Kind::kTuple, "a tuple");
    Call(Pop(Kind::kGlobal, "a name")->text, arguments->items);
  }
  void Build() {
    const Value* state = Pop(Kind::kTuple, "a tuple");
    SetState(Pop(), state->items);
  }

  void Remember(uint64_t place) { memory_[place] = Top(); }
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

// As Python's pickletools names them.
const PickleReader::Instruction PickleReader::kInstructions[] = {
    {0x80, [](PickleReader* r) { r->ReadCount(1); }},    // PROTO
    {0x95, [](PickleReader* r) { r->ReadCount(8); }},    // FRAME
    {'(', [](PickleReader* r) { r->Push(Kind::kMark); }},
    {'0', [](PickleReader* r) { r->Pop(); }},
    {'1', [](PickleReader* r) { r->PopToMark(); }},
    {')', [](PickleReader* r) { r->PushItems(Kind::kTuple, {}); }},
    // TUPLE1 .. TUPLE3
    {0x85, [](PickleReader* r) { r->PushItems(Kind::kTuple, r->PopMany(1)); }},
    {0x86, [](PickleReader* r) { r->PushItems(Kind::kTuple, r->PopMany(2)); }},
    {0x87, [](PickleReader* r) { r->PushItems(Kind::kTuple, r->PopMany(3)); }},
    {'t', [](PickleReader* r) { r->PushItems(Kind::kTuple, r->PopToMark()); }},
    {']', [](PickleReader* r) { r->PushItems(Kind::kList, {}); }},
    {'l', [](PickleReader* r) { r->PushItems(Kind::kList, r->PopToMark()); }},
    {'}', [](PickleReader* r) { r->PushItems(Kind::kDict, {}); }},
    {'d', [](PickleReader* r) { r->PushItems(Kind::kDict, r->PopToMark()); }},
    // APPEND, APPENDS, SETITEM, SETITEMS
    {'a', [](PickleReader* r) { r->Append(Kind::kList, r->PopMany(1)); }},
    {'e', [](PickleReader* r) { r->Append(Kind::kList, r->PopToMark()); }},
    {'s', [](PickleReader* r) { r->Append(Kind::kDict, r->PopMany(2)); }},
    {'u', [](PickleReader* r) { r->Append(Kind::kDict, r->PopToMark()); }},
    // GLOBAL, STACK_GLOBAL
    {'c', [](PickleReader* r) { r->PushGlobalLines(); }},
    {0x93, [](PickleReader* r) { r->PushGlobalOfStack(); }},
    {'R', [](PickleReader* r) { r->Reduce(); }},
    {'b', [](PickleReader* r) { r->Build(); }},
    {'N', [](PickleReader* r) { r->Push(Kind::kNone); }},
    // NEWTRUE, NEWFALSE
    {0x88, [](PickleReader* r) { r->Push(Kind::kBoolean)->integer = 1; }},
    {0x89, [](PickleReader* r) { r->Push(Kind::kBoolean)->integer = 0; }},
    // BININT1, BININT2, BININT, LONG1
    {'K', [](PickleReader* r) { r->PushInteger(r->ReadCount(1)); }},
    {'M', [](PickleReader* r) { r->PushInteger(r->ReadCount(2)); }},
    {'J',
     [](PickleReader* r) {
       r->PushInteger(int64_t{static_cast<int32_t>(r->ReadCount(4))});
     }},
    {0x8a, [](PickleReader* r) { r->PushInteger(r->ReadLong()); }},
    // BINFLOAT, the one that is big-endian
    {'G',
     [](PickleReader* r) {
       r->Push(Kind::kNumber)->number = Load<double>(r->Take(8), true);
     }},
    // SHORT_BINUNICODE, BINUNICODE, BINUNICODE8; UNICODE, of protocol 0
    {0x8c, [](PickleReader* r) { r->PushBytes(Kind::kText, 1); }},
    {'X', [](PickleReader* r) { r->PushBytes(Kind::kText, 4); }},
    {0x8d, [](PickleReader* r) { r->PushBytes(Kind::kText, 8); }},
    {'V', [](PickleReader* r) { r->PushText(Kind::kText, r->ReadLine()); }},
    // SHORT_BINSTRING, BINSTRING: Python 2's texts are bytes
    {'U', [](PickleReader* r) { r->PushBytes(Kind::kText, 1); }},
    {'T', [](PickleReader* r) { r->PushBytes(Kind::kText, 4); }},
    // SHORT_BINBYTES, BINBYTES, BINBYTES8, BYTEARRAY8
    {'C', [](PickleReader* r) { r->PushBytes(Kind::kBytes, 1); }},
    {'B', [](PickleReader* r) { r->PushBytes(Kind::kBytes, 4); }},
    {0x8e, [](PickleReader* r) { r->PushBytes(Kind::kBytes, 8); }},
    {0x96, [](PickleReader* r) { r->PushBytes(Kind::kBytes, 8); }},
    // MEMOIZE, BINPUT, LONG_BINPUT; PUT, of protocol 0
    {0x94, [](PickleReader* r) { r->Remember(r->memory_.size()); }},
    {'q', [](PickleReader* r) { r->Remember(r->ReadCount(1)); }},
    {'r', [](PickleReader* r) { r->Remember(r->ReadCount(4)); }},
    {'p', [](PickleReader* r) { r->Remember(r->ReadNumberLine()); }},
    // GET, of protocol 0; BINGET, LONG_BINGET
    {'g', [](PickleReader* r) { r->Recall(r->ReadNumberLine()); }},
    {'h', [](PickleReader* r) { r->Recall(r->ReadCount(1)); }},
    {'j', [](PickleReader* r) { r->Recall(r->ReadCount(4)); }}};

Json PickleReader::Read() {
  while (true) {
    const size_t place = at_;
    const auto code = static_cast<unsigned char>(Take(1)[0]);
    if (code == '.') break;
    const auto* const at = std::find_if(
        std::begin(kInstructions), std::end(kInstructions),
        [code](const Instruction& one) { return one.code == code; });
    if (at == std::end(kInstructions)) {
      Fail("byte " + std::to_string(place) + ": found the instruction " +
           std::to_string(code) +
           ", which no pickle of numbers and NumPy arrays needs");
    }
    at->run(this);
  }
  size_t budget = kMaxPickled;
  return ToJson(*Pop(), 0, &budget);
}

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

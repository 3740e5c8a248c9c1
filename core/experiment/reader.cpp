#include "core/experiment/reader.hpp"

#include <fstream>
#include <sstream>
#include <system_error>
#include <unordered_map>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

namespace somas::experiment {
namespace {

// Builds the tree from the parser's events: yaml-cpp's own nodes forget duplicate keys.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const std::string& origin) : origin_(origin) {}

  [[nodiscard]] Node take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Node node;
    node.position = at(mark);
    refuse_anchor(anchor, node.position);
    if (expects_key()) fail(node.position, "a key is missing before ':'");
    add(std::move(node));
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(at(mark), "aliases (*name) are not supported; write the value out, or use 'extends'");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node;
    node.kind = Node::Kind::scalar;
    node.text = value;
    node.quoted = tag == "!";
    node.position = at(mark);
    refuse_anchor(anchor, node.position);
    refuse_tag(tag, node.position);
    if (expects_key()) {
      take_key(value, node.position);
    } else {
      add(std::move(node));
    }
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(Node::Kind::sequence, mark, tag, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(Node::Kind::mapping, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  // A collection that is not closed yet, and the key that waits for its value.
  struct Open {
    Node node;
    bool is_key = false;
    bool has_key = false;
    std::string key;
    Position key_position;
    std::unordered_map<std::string, Position> keys;
  };

  [[nodiscard]] Position at(const YAML::Mark& mark) const {
    return {origin_, static_cast<std::size_t>(mark.line) + 1,
            static_cast<std::size_t>(mark.column) + 1};
  }

  [[nodiscard]] bool expects_key() const {
    return !open_.empty() && open_.back().node.kind == Node::Kind::mapping && !open_.back().has_key;
  }

  [[noreturn]] void fail(const Position& position, const std::string& message) const {
    const std::string path = this->path();
    throw InputError(position, path.empty() ? message : path + ": " + message);
  }

  // "world.kinds[2].attenuation", as far as the document is open.
  [[nodiscard]] std::string path() const {
    std::string path;
    for (const Open& open : open_) {
      if (open.node.kind == Node::Kind::sequence) {
        path = indexed(path, open.node.items.size());
      } else if (open.has_key) {
        path += (path.empty() ? "" : ".") + open.key;
      }
    }
    return path;
  }

  void refuse_anchor(YAML::anchor_t anchor, const Position& position) const {
    if (anchor != YAML::NullAnchor)
      fail(position, "anchors (&name) are not supported; write the value out, or use 'extends'");
  }

  // yaml-cpp's own tags: "?" plain, "!" quoted, nothing for collections.
  void refuse_tag(const std::string& tag, const Position& position) const {
    if (!tag.empty() && tag != "?" && tag != "!")
      fail(position, "tags (!name) are not supported; remove it");
  }

  void take_key(const std::string& key, const Position& position) {
    Open& mapping = open_.back();
    if (key == "<<") fail(position, "merge keys (<<) are not supported; use 'extends'");
    mapping.has_key = true;
    mapping.key = key;
    mapping.key_position = position;
    const auto [first, is_new] = mapping.keys.try_emplace(key, position);
    if (!is_new) fail(position, "duplicate key; it was first given at " + first->second.text());
  }

  void add(Node node) {
    if (open_.empty()) {
      node.key_position = node.position;
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    node.key_position = node.position;
    if (parent.node.kind == Node::Kind::mapping) {
      node.key = parent.key;
      node.key_position = parent.key_position;
      parent.has_key = false;
    }
    parent.node.items.push_back(std::move(node));
  }

  void open(Node::Kind kind, const YAML::Mark& mark, const std::string& tag,
            YAML::anchor_t anchor) {
    const Position position = at(mark);
    refuse_anchor(anchor, position);
    refuse_tag(tag, position);
    const bool is_key = expects_key();
    if (open_.size() >= deepest_nesting)
      throw InputError(position,
                       "nested deeper than " + std::to_string(deepest_nesting) + " levels");
    Open& opened = open_.emplace_back();
    opened.is_key = is_key;
    opened.node.kind = kind;
    opened.node.position = position;
  }

  // An unclosed bracket looks like a key to yaml-cpp, so this waits until it is really closed.
  void close() {
    const bool is_key = open_.back().is_key;
    Node done = std::move(open_.back().node);
    open_.pop_back();
    if (is_key) fail(done.position, "a key must be a text");
    add(std::move(done));
  }

  std::string origin_;
  std::vector<Open> open_;
  Node root_;
};

// Length of the UTF-8 sequence at `i`, 0 when it is none.
std::size_t sequence_length(const std::string& text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char lead = byte(i);
  const std::size_t length = lead < 0x80                    ? 1
                             : lead >= 0xC2 && lead <= 0xDF ? 2
                             : lead >= 0xE0 && lead <= 0xEF ? 3
                             : lead >= 0xF0 && lead <= 0xF4 ? 4
                                                            : 0;
  if (length == 0 || length > text.size() - i) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(i + k) & 0xC0) != 0x80) return 0;

  // Overlong forms, surrogates and what lies beyond Unicode.
  if (length < 3) return length;
  const unsigned char second = byte(i + 1);
  const bool wrong = (lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F) ||
                     (lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second > 0x8F);
  return wrong ? 0 : length;
}

// yaml-cpp takes some control characters for the end of the file.
void check_characters(const std::string& text, const std::string& origin) {
  Position position{origin, 1, 1};
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t length = sequence_length(text, i);
    if (length == 0) throw InputError(position, "not UTF-8 text; save the file as UTF-8");
    const bool blank = byte == '\n' || byte == '\t' || byte == '\r';
    if ((byte < 0x20 && !blank) || byte == 0x7F)
      throw InputError(position, "a control character: not a text file, or a damaged one");
    position.column = byte == '\n' ? 1 : position.column + 1;
    position.line += byte == '\n' ? 1 : 0;
    i += length;
  }
}

Position place_of(const YAML::Exception& error, const std::string& origin) {
  // Some of its errors know no place.
  if (error.mark.is_null()) return {origin, 1, 1};
  return {origin, static_cast<std::size_t>(error.mark.line) + 1,
          static_cast<std::size_t>(error.mark.column) + 1};
}

// yaml-cpp closes an open quote by itself at a last line break, and complains only without one.
void refuse_open_quote(const std::string& text, const std::string& origin) {
  std::istringstream stream(text.substr(0, text.find_last_not_of("\r\n") + 1));
  TreeBuilder nobody(origin);
  try {
    YAML::Parser(stream).HandleNextDocument(nobody);
  } catch (const YAML::Exception& error) {
    if (error.msg == YAML::ErrorMsg::EOF_IN_SCALAR)
      throw InputError(place_of(error, origin), "not valid YAML: a quote is not closed");
  }
}

void place_all(Node& node, const Position& position) {
  node.position = position;
  node.key_position = position;
  for (Node& item : node.items) place_all(item, position);
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  const Position whole{file.string(), 0, 0};
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw InputError(whole, "no such file");
  if (std::filesystem::is_directory(status))
    throw InputError(whole, "a directory, not an experiment file");
  if (!std::filesystem::is_regular_file(status)) throw InputError(whole, "not a regular file");
  if (std::filesystem::file_size(file, error) > largest_file)
    throw InputError(whole, "larger than 1 MiB: not an experiment file");

  // It may still grow: read at most what is allowed, and one more to notice.
  std::ifstream stream(file, std::ios::binary);
  std::string text(largest_file + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || (!stream && !stream.eof())) throw InputError(whole, "cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > largest_file)
    throw InputError(whole, "larger than 1 MiB: not an experiment file");
  check_characters(text, file.string());
  return text;
}

std::string fault_in_name(const std::string& text) {
  constexpr std::size_t longest = 100;
  if (text.empty() || text.find('/') != std::string::npos)
    return "a name must not be empty or contain '/'";
  if (text.size() > longest)
    return "a name of " + std::to_string(text.size()) + " bytes; allowed: at most " +
           std::to_string(longest);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequence_length(text, i);
    if (length == 0) return "a name must be UTF-8 text; byte " + std::to_string(i + 1) + " is none";
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool c1 = byte == 0xC2 && static_cast<unsigned char>(text[i + 1]) < 0xA0;
    if (byte < 0x20 || byte == 0x7F || c1)
      return "a name must not contain control characters; byte " + std::to_string(i + 1) +
             " is one";
    i += length;
  }
  return {};
}

Node parse_yaml(const std::string& text, const std::string& origin) {
  refuse_open_quote(text, origin);
  std::istringstream stream(text);
  TreeBuilder builder(origin);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) throw InputError({origin, 1, 1}, "the file is empty");
    Node root = builder.take();
    if (parser.HandleNextDocument(builder))
      throw InputError(builder.take().position,
                       "a second document; an experiment is a single one, without '---' inside");
    return root;
  } catch (const YAML::Exception& error) {
    throw InputError(place_of(error, origin), "not valid YAML: " + error.msg);
  }
}

Node parse_value(const std::string& text, const Position& position) {
  Node node;
  if (!text.empty()) {
    try {
      check_characters(text, position.origin);
      node = parse_yaml(text, position.origin);
    } catch (const InputError& error) {
      // "ORIGIN:1:5: message": the place within a command line helps nobody.
      const std::string what = error.what(), prefix = error.position().text() + ": ";
      throw InputError(position, what.substr(what.starts_with(prefix) ? prefix.size() : 0));
    }
  }
  place_all(node, position);
  return node;
}

}  // namespace somas::experiment

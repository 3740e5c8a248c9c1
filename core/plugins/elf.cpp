#include "core/plugins/elf.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <elf.h>
#include <fstream>
#include <optional>
#include <system_error>
#include <vector>

#include "somas/sdk/abi.hpp"

namespace somas::plugins {
namespace {

#if defined(__aarch64__)
constexpr unsigned host_machine = EM_AARCH64;
#else
constexpr unsigned host_machine = EM_X86_64;
#endif

std::string machine_name(unsigned machine) {
  switch (machine) {
    case EM_386:
      return "i386";
    case EM_X86_64:
      return "x86-64";
    case EM_ARM:
      return "arm";
    case EM_AARCH64:
      return "aarch64";
    case EM_PPC64:
      return "ppc64";
    case EM_RISCV:
      return "riscv";
    case EM_S390:
      return "s390";
    default:
      return "machine " + std::to_string(machine);
  }
}

std::string type_name(unsigned type) {
  switch (type) {
    case ET_REL:
      return "an object file";
    case ET_EXEC:
      return "a program";
    case ET_CORE:
      return "a core dump";
    default:
      return "of unknown type";
  }
}

[[noreturn]] void truncated(const std::string& what) {
  throw BadPlugin("truncated: " + what + "; copy or build it again");
}

// A file that is only ever read within its bounds.
class Image {
 public:
  explicit Image(const std::filesystem::path& file) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) throw BadPlugin("no such file");
    if (std::filesystem::is_directory(status)) throw BadPlugin("a directory, not a file");
    if (!std::filesystem::is_regular_file(status)) throw BadPlugin("not a regular file");
    size_ = std::filesystem::file_size(file, error);
    stream_.open(file, std::ios::binary);
    if (error || !stream_) throw BadPlugin("cannot be read; check its permissions");
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] bool holds(std::uint64_t offset, std::uint64_t length) const {
    return offset <= size_ && length <= size_ - offset;
  }

  void read(std::uint64_t offset, void* to, std::size_t length, const char* what) {
    if (!holds(offset, length)) truncated(what + std::string(" lies beyond the end of the file"));
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(length));
    if (!stream_) truncated(what + std::string(" cannot be read"));
  }

 private:
  std::uint64_t size_ = 0;
  std::ifstream stream_;
};

Elf64_Ehdr read_header(Image& image) {
  unsigned char magic[EI_NIDENT] = {};
  if (image.size() == 0) throw BadPlugin("an empty file; build it again");
  image.read(0, magic, std::min<std::uint64_t>(image.size(), sizeof magic), "the ELF header");
  if (std::memcmp(magic, ELFMAG, SELFMAG) != 0)
    throw BadPlugin("not a shared library (it has no ELF header); build it with somas_add_plugin");
  Elf64_Ehdr header;
  image.read(0, &header, sizeof header, "the ELF header");

  if (magic[EI_CLASS] != ELFCLASS64) throw BadPlugin("built for a 32-bit machine; rebuild it");
  if (magic[EI_DATA] != ELFDATA2LSB) throw BadPlugin("built for a big-endian machine; rebuild it");
  if (header.e_machine != host_machine)
    throw BadPlugin("built for another architecture (" + machine_name(header.e_machine) +
                    "), this host is " + machine_name(host_machine) + "; rebuild it");
  if (header.e_type != ET_DYN)
    throw BadPlugin("not a shared library, but " + type_name(header.e_type) +
                    "; build it with somas_add_plugin");
  return header;
}

// The loader maps segments without asking whether the file still holds them.
void check_segments(Image& image, const Elf64_Ehdr& header) {
  if (header.e_phentsize != sizeof(Elf64_Phdr)) throw BadPlugin("its program headers are damaged");
  for (std::uint64_t i = 0; i < header.e_phnum; ++i) {
    Elf64_Phdr segment;
    image.read(header.e_phoff + i * sizeof segment, &segment, sizeof segment, "a program header");
    if (!image.holds(segment.p_offset, segment.p_filesz))
      truncated("segment " + std::to_string(i) + " lies beyond the end of the file");
  }
}

std::vector<Elf64_Shdr> read_sections(Image& image, const Elf64_Ehdr& header) {
  if (header.e_shnum == 0) return {};
  if (header.e_shentsize != sizeof(Elf64_Shdr)) throw BadPlugin("its section headers are damaged");
  std::vector<Elf64_Shdr> sections(header.e_shnum);
  image.read(header.e_shoff, sections.data(), sections.size() * sizeof(Elf64_Shdr),
             "the table of sections");
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (sections[i].sh_type != SHT_NOBITS &&
        !image.holds(sections[i].sh_offset, sections[i].sh_size))
      truncated("section " + std::to_string(i) + " lies beyond the end of the file");
  return sections;
}

std::string section_name(Image& image, const Elf64_Shdr& names, const Elf64_Shdr& section) {
  char text[32] = {};
  if (section.sh_name >= names.sh_size) return {};
  const std::uint64_t length =
      std::min<std::uint64_t>(sizeof text - 1, names.sh_size - section.sh_name);
  image.read(names.sh_offset + section.sh_name, text, length, "a section's name");
  return text;
}

// One ELF note: three sizes, the owner padded to 4 bytes, the description.
std::string note_text(Image& image, const Elf64_Shdr& section) {
  PluginNote note;
  const char* remedy = "its SOMAS note is damaged; build it again";
  if (section.sh_size < sizeof note) throw BadPlugin(remedy);
  image.read(section.sh_offset, &note, sizeof note, "the SOMAS note");
  const PluginNote expected;
  if (note.name_size != expected.name_size || note.type != expected.type ||
      note.description_size != expected.description_size ||
      std::memcmp(note.name, expected.name, sizeof note.name) != 0)
    throw BadPlugin(remedy);
  return {note.description, ::strnlen(note.description, sizeof note.description)};
}

// The number in "somas-abi NUMBER; ...".
std::optional<unsigned> revision_of(std::string_view fingerprint) {
  constexpr std::string_view before = "somas-abi ";
  if (!fingerprint.starts_with(before)) return std::nullopt;
  fingerprint.remove_prefix(before.size());
  unsigned revision = 0;
  const auto [end, error] =
      std::from_chars(fingerprint.data(), fingerprint.data() + fingerprint.size(), revision);
  if (error != std::errc{}) return std::nullopt;
  return revision;
}

}  // namespace

std::string read_fingerprint(const std::filesystem::path& file) {
  Image image(file);
  const Elf64_Ehdr header = read_header(image);
  check_segments(image, header);
  const std::vector<Elf64_Shdr> sections = read_sections(image, header);
  if (header.e_shstrndx < sections.size())
    for (const Elf64_Shdr& section : sections)
      if (section.sh_type == SHT_NOTE &&
          section_name(image, sections[header.e_shstrndx], section) == plugin_note_section)
        return note_text(image, section);
  throw BadPlugin(
      "no SOMAS note: not a plugin, or built without SOMAS_PLUGIN; name it "
      "otherwise, or rebuild it so");
}

std::vector<std::string> imported_functions(const std::filesystem::path& file) {
  Image image(file);
  const Elf64_Ehdr header = read_header(image);
  const std::vector<Elf64_Shdr> sections = read_sections(image, header);
  std::vector<std::string> names;
  for (const Elf64_Shdr& table : sections) {
    if (table.sh_type != SHT_DYNSYM || table.sh_link >= sections.size()) continue;
    const Elf64_Shdr& texts = sections[table.sh_link];
    if (texts.sh_type == SHT_NOBITS || table.sh_entsize != sizeof(Elf64_Sym)) continue;
    std::string text(texts.sh_size, '\0');
    image.read(texts.sh_offset, text.data(), text.size(), "the names of symbols");
    std::vector<Elf64_Sym> symbols(table.sh_size / sizeof(Elf64_Sym));
    image.read(table.sh_offset, symbols.data(), symbols.size() * sizeof(Elf64_Sym), "the symbols");
    for (const Elf64_Sym& symbol : symbols) {
      if (symbol.st_shndx != SHN_UNDEF || symbol.st_name == 0 || symbol.st_name >= text.size())
        continue;
      names.emplace_back(text.c_str() + symbol.st_name);
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

void check_fingerprint(const std::string& fingerprint) {
  if (fingerprint == SOMAS_FINGERPRINT) return;
  const std::optional<unsigned> revision = revision_of(fingerprint);
  const std::string host = std::to_string(SOMAS_ABI_REVISION);
  if (revision && *revision < SOMAS_ABI_REVISION)
    throw BadPlugin("built for interface revision " + std::to_string(*revision) +
                    ", this host needs " + host + ": rebuild it with the SDK of this host");
  if (revision && *revision > SOMAS_ABI_REVISION)
    throw BadPlugin("built for interface revision " + std::to_string(*revision) +
                    ", this host is older and needs " + host +
                    ": use a newer SOMAS, or rebuild it with the SDK of this host");
  throw BadPlugin("built against another SDK: has '" + fingerprint + "', this host needs '" +
                  SOMAS_FINGERPRINT + "': rebuild it");
}

}  // namespace somas::plugins

#include "core/report/page.hpp"

#include <limits>
#include <stdexcept>
#include <zlib.h>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>

namespace somas::report {

// Generated from web/dist/replay.html by cmake/EmbedFile.cmake.
extern const unsigned char replay_page[];
extern const unsigned long long replay_page_size;

namespace {

constexpr std::string_view place = "<!--recordings-->";

std::string gzip(std::string_view bytes) {
  z_stream stream{};
  constexpr int gzip_format = 15 + 16;  // window bits; no name and no time in the header
  if (deflateInit2(&stream, 6, Z_DEFLATED, gzip_format, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("cannot compress the page's recording: no memory");
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  if (packed.size() > std::numeric_limits<uInt>::max()) {
    deflateEnd(&stream);
    throw std::runtime_error(
        "the recording is larger than a page can hold (4 GB); record fewer frames");
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw std::runtime_error("cannot compress the page's recording");
  return packed;
}

std::string base64(const std::string& bytes) {
  using namespace boost::archive::iterators;
  using Digits = base64_from_binary<transform_width<std::string::const_iterator, 6, 8>>;
  std::string text(Digits(bytes.begin()), Digits(bytes.end()));
  text.append((3 - bytes.size() % 3) % 3, '=');
  return text;
}

}  // namespace

std::string_view page_template() {
  return {reinterpret_cast<const char*>(replay_page), static_cast<std::size_t>(replay_page_size)};
}

std::string build_page(std::span<const std::string> lives) {
  const std::string_view page = page_template();
  const std::size_t at = page.find(place);
  if (at == std::string_view::npos || page.find(place, at + 1) != std::string_view::npos)
    throw std::logic_error("web/dist/replay.html needs one place for recordings");
  std::string text(page.substr(0, at));
  for (const std::string& life : lives)
    text += "<script type=\"application/x-somas-recording\">" + base64(gzip(life)) + "</script>\n";
  text += page.substr(at + place.size());
  return text;
}

}  // namespace somas::report

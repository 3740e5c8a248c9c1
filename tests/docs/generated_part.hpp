// A part of a page that a test writes from what it asserts: between <!-- checked: NAME --> and the
// next <!-- end -->. SOMAS_UPDATE_DOCS=1 renews it.
#pragma once

#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>
#include <sys/file.h>

namespace somas::test {

/// Expects the part of `page` to be `text`, or makes it so.
inline void expect_part(const std::string& page, const std::string& name, const std::string& text) {
  // Tests of several programs may renew one page at a time.
  const int lock = ::open(page.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(lock, 0) << page;
  ::flock(lock, LOCK_EX);
  std::ifstream in(page, std::ios::binary);
  const std::string whole(std::istreambuf_iterator<char>(in), {});
  const std::string opening = "<!-- checked: " + name + " -->\n";
  const std::size_t mark = whole.find(opening), begin = mark + opening.size();
  const std::size_t end = whole.find("<!-- end -->", mark);
  if (mark == std::string::npos || end == std::string::npos) {
    ADD_FAILURE() << page << " has no part '" << name << "'";
  } else if (whole.substr(begin, end - begin) != "\n" + text + "\n") {
    if (std::getenv("SOMAS_UPDATE_DOCS") != nullptr)
      std::ofstream(page, std::ios::binary) << whole.substr(0, begin) << "\n"
                                            << text << "\n"
                                            << whole.substr(end);
    else
      ADD_FAILURE() << page << " is out of date; run: SOMAS_UPDATE_DOCS=1 ./dev test -R Generated";
  }
  ::close(lock);
}

}  // namespace somas::test

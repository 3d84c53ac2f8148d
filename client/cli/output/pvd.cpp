// Series of files for ParaView.

#include "client/cli/output/number_file.hpp"
#include "client/cli/output/paraview.hpp"

namespace collided::cli {

namespace {

/// As the value of an XML attribute.
std::string quoted(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace

void write_pvd(const std::string& file, const std::vector<TimedFile>& files) {
  NumberFile out(file);
  out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
  for (const TimedFile& one : files)
    out.text("<DataSet timestep=\"").number(one.time).text("\" file=\"").text(quoted(one.file)).text("\"/>\n");
  out.text("</Collection>\n</VTKFile>\n");
  out.finish();
}

}  // namespace collided::cli

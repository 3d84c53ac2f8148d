// Series of files for ParaView.

#include "client/app/output/markup.hpp"
#include "client/app/output/number_file.hpp"
#include "client/app/output/paraview.hpp"

namespace collided::cli {

void write_pvd(const std::string& file, const std::vector<TimedFile>& files) {
  NumberFile out(file);
  out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
  for (const TimedFile& one : files)
    out.text("<DataSet timestep=\"").number(one.time).text("\" file=\"").text(escape_markup(one.file)).text("\"/>\n");
  out.text("</Collection>\n</VTKFile>\n");
  out.finish();
}

}  // namespace collided::cli

#!/usr/bin/env python3
"""The checker finds one bad include at a time in a temporary tree."""

import pathlib
import tempfile
import unittest

import check_layers

GOOD = {
    "gpu/contact_set.hpp": "#pragma once\n#include <vector>\n",
    "gpu/types.hpp": '#pragma once\n#include "gpu/contact_set.hpp"\n',
    "gpu/detector.hpp": '#pragma once\n#include "gpu/types.hpp"\n',
    "gpu/detector.cpp": '#include "gpu/detector.hpp"\n#include "gpu/scene/rules.hpp"\n',
    "gpu/scene/rules.hpp": '#include "gpu/step/pipeline.hpp"\n#include "gpu/detector.hpp"\n',
    "gpu/scene/backend.cu": "#include <cuda_runtime.h>\n",
    "gpu/step/pipeline.hpp": '#include "gpu/engines/octree/count.hpp"\n#include "gpu/narrow/ccd.hpp"\n',
    "gpu/step/list.hpp": '#include "gpu/exact/exact.hpp"\n#include "gpu/exact/fixed/decide.hpp"\n',
    "gpu/exact/fixed/decide.hpp": '#include "gpu/exact/fixed/integer.hpp"\n',
    "gpu/exact/fixed/integer.hpp": '#include "gpu/base/vec3.hpp"\n',
    "gpu/engines/octree/count.hpp": '#include "gpu/exec/cpu.hpp"\n#include "gpu/base/box.hpp"\n#include <cmath>\n',
    "gpu/narrow/ccd.hpp": '#include "gpu/base/box.hpp"\n',
    "gpu/exec/cpu.hpp": "#include <oneapi/tbb/parallel_for.h>\n",
    "gpu/exec/cuda/cuda.cuh": "#include <cub/cub.cuh>\n#include <cuda_runtime.h>\n",
    "gpu/base/box.hpp": "#include <array>\n",
    "gpu/base/vec3.hpp": "#include <cstddef>\n",
    "gpu/base/host_device.hpp": "#include <cstddef>\n",
    "gpu/exact/exact.hpp": '#include "gpu/base/vec3.hpp"\n#include "gpu/contact_set.hpp"\n',
    "gpu/exact/polynomial.hpp": '#include <gmpxx.h>\n#include "gpu/base/host_device.hpp"\n',
    "gpu/exact/ccd.cpp": '#include "gpu/exact/polynomial.hpp"\n#include <gmp.h>\n',
    "proto/constants.hpp": "#include <cstdint>\n",
    "server/errors.hpp": "#include <string>\n",
    "server/main.cpp": '#include "server/daemon.hpp"\n#include "server/devices/turns.hpp"\n#include <grpc/grpc.h>\n',
    "server/ops/clock.hpp": "#include <chrono>\n",
    "server/devices/turns.hpp": '#include "server/errors.hpp"\n#include "server/ops/clock.hpp"\n',
    "server/scenes/scene.hpp": '#include "gpu/detector.hpp"\n#include "server/devices/turns.hpp"\n',
    "server/auth/credentials.cpp": "#include <grpcpp/security/server_credentials.h>\n",
    "server/frames/session.hpp": '#include "server/scenes/scene.hpp"\n',
    "server/frames/intake.cpp": '#include "collided/v1/frame.pb.h"\n#include "server/convert/frame.hpp"\n',
    "server/transport/local/packets.cpp": '#include "proto/constants.hpp"\n#include "server/frames/session.hpp"\n',
    "server/service/service.cpp": '#include "collided/v1/frame.pb.h"\n#include "server/transport/grpc/call.hpp"\n',
    "client/cpp/client.hpp": '#include "collided/v1/collision_service.grpc.pb.h"\n',
    "client/c/scene.cpp": '#include "client/c/include/collided/collided.h"\n#include "gpu/detector.hpp"\n',
    "client/in_process/local.cpp": '#include "client/cpp/transport/channel.hpp"\n#include "server/in_process.hpp"\n',
}
BAD = [
    ("client/cpp/bad.hpp", '#include "server/in_process.hpp"'),
    ("client/cli/bad.cpp", '#include "server/in_process.hpp"'),
    ("client/cli/bad.cpp", '#include "client/in_process/local.hpp"'),
    ("client/cpp/bad.cpp", '#include "client/in_process/local.hpp"'),
    ("client/c/bad.cpp", '#include "gpu/scene/rules.hpp"'),
    ("client/c/bad.cpp", '#include "server/errors.hpp"'),
    ("client/c/bad.cpp", '#include "client/cpp/client.hpp"'),
    ("client/c/bad.cpp", '#include <grpcpp/grpcpp.h>'),
    ("client/c/bad.cpp", '#include "collided/v1/frame.pb.h"'),
    ("client/cpp/bad.cpp", '#include "client/c/include/collided/collided.h"'),
    ("client/in_process/bad.cpp", '#include "server/scenes/scene.hpp"'),
    ("client/in_process/bad.cpp", '#include "gpu/detector.hpp"'),
    ("client/in_process/bad.cpp", '#include "client/scenes/scene.hpp"'),
    ("client/in_process/local.hpp", '#include "server/in_process.hpp"'),
    ("server/transport/in_process/bad.hpp", '#include "server/transport/local/packets.hpp"'),
    ("server/transport/in_process/bad.hpp", '#include "client/cpp/client.hpp"'),
    ("gpu/engines/octree/bad.hpp", '#include "gpu/search/pairs.hpp"'),
    ("gpu/search/bad.hpp", '#include "gpu/narrow/ccd.hpp"'),
    ("gpu/narrow/bad.cu", '#include "gpu/engines/octree/count.hpp"'),
    ("gpu/engines/octree/bad.hpp", '#include "gpu/step/pipeline.hpp"'),
    ("gpu/step/bad.hpp", '#include "gpu/scene/rules.hpp"'),
    ("gpu/step/bad.hpp", '#include "gpu/positions/slot.hpp"'),
    ("gpu/step/bad.hpp", '#include "gpu/detector.hpp"'),
    ("gpu/types.hpp", '#include "gpu/detector.hpp"'),
    ("gpu/attic/bad.hpp", '#include "gpu/base/box.hpp"'),
    ("gpu/exec/bad.hpp", '#include "gpu/contacts/contact.hpp"'),
    ("gpu/base/bad.hpp", '#include "gpu/engines/octree/count.hpp"'),
    ("gpu/base/bad.hpp", '#include "gpu/types.hpp"'),
    ("gpu/base/bad.hpp", '#include "server/convert.hpp"'),
    ("gpu/base/bad.hpp", '#include "base/box.hpp"'),
    ("gpu/narrow/bad.hpp", '#include "gpu/exact/exact.hpp"'),
    ("gpu/base/bad.hpp", '#include "gpu/exact/exact.hpp"'),
    ("gpu/base/bad.hpp", '#include "gpu/contact_set.hpp"'),
    ("gpu/exact/bad.hpp", '#include "gpu/narrow/ccd.hpp"'),
    ("gpu/exact/bad.hpp", '#include "gpu/step/pipeline.hpp"'),
    ("gpu/exact/bad.hpp", '#include "gpu/exec/cpu.hpp"'),
    ("gpu/exact/bad.hpp", '#include "gpu/base/lattice.hpp"'),
    ("gpu/exact/exact.hpp", "#include <gmpxx.h>"),
    ("gpu/exact/decision.hpp", "#include <gmp.h>"),
    ("gpu/exact/fixed/bad.hpp", "#include <gmp.h>"),
    ("gpu/exact/fixed/bad.hpp", '#include "gpu/exact/polynomial.hpp"'),
    ("gpu/step/bad.hpp", '#include "gpu/exact/fixed/integer.hpp"'),
    ("gpu/detector.cpp", "#include <gmpxx.h>"),
    ("gpu/scene/backends/backend_cpu.cpp", '#include "gpu/exact/polynomial.hpp"'),
    ("server/worker.cpp", "#include <gmpxx.h>"),
    ("server/worker.cpp", '#include "gpu/exact/exact.hpp"'),
    ("gpu/exec/bad.hpp", "#include <cuda_runtime.h>"),
    ("gpu/engines/octree/bad.cuh", "#include <cub/cub.cuh>"),
    ("gpu/detector.cpp", "#include <spdlog/spdlog.h>"),
    ("gpu/detector.cpp", "#include <grpcpp/grpcpp.h>"),
    ("gpu/detector.cpp", "#include <collided/v1/frame.pb.h>"),
    ("server/scenes/store.cpp", '#include "collided/v1/frame.pb.h"'),
    ("server/scenes/store.cpp", '#include "proto/constants.hpp"'),
    ("server/scenes/store.cpp", '#include "server/frames/session.hpp"'),
    ("server/scenes/store.cpp", '#include "server/convert/scene.hpp"'),
    ("server/scenes/scene/engine.cpp", '#include "server/scenes/scene.hpp"'),
    ("server/devices/turns.cpp", '#include "server/scenes/scene.hpp"'),
    ("server/devices/turns.cpp", '#include "server/limits/client_usage.hpp"'),
    ("server/devices/turns.cpp", "#include <grpcpp/grpcpp.h>"),
    ("server/auth/tokens.cpp", "#include <google/protobuf/message.h>"),
    ("server/convert/frame.cpp", '#include "server/frames/frame.hpp"'),
    ("server/frames/session.cpp", '#include "collided/v1/frame.pb.h"'),
    ("server/frames/session.cpp", '#include "server/transport/local/packets.hpp"'),
    ("server/transport/grpc/call.cpp", '#include "server/transport/local/packets.hpp"'),
    ("server/transport/local/call.cpp", '#include "server/transport/grpc/call.hpp"'),
    ("server/transport/grpc/call.cpp", '#include "server/service/service.hpp"'),
    ("server/service/service.cpp", '#include "server/daemon.hpp"'),
    ("server/attic/box.cpp", '#include "server/ops/log.hpp"'),
    ("gpu/detector.cpp", '#include "proto/constants.hpp"'),
    ("proto/constants.hpp", '#include "server/errors.hpp"'),
    ("server/worker.cpp", '#  include "gpu/step/pipeline.hpp"'),
    ("server/worker.cpp", "#include <cuda_runtime.h>"),
    ("server/service/service.cpp", '#include "client/cpp/client.hpp"'),
    ("client/cli/main.cpp", '#include "gpu/detector.hpp"'),
    ("client/cli/main.cpp", '#include "server/config.hpp"'),
    ("client/scenes/bad.cpp", '#include "client/cpp/client.hpp"'),
    ("client/cpp/bad.cpp", '#include "client/scenes/scene.hpp"'),
    ("client/cpp/frame_stream.hpp", '#include "client/cpp/transport/frame_transport.hpp"'),
    ("client/cpp/transport/grpc/bad.cpp", '#include "client/cpp/frame_stream.hpp"'),
    ("client/app/report/bad.cpp", '#include "client/cli/commands.hpp"'),
    ("client/app/report/bad.cpp", '#include "client/measure/statistics.hpp"'),
    ("client/app/report/bad.cpp", '#include "client/cli/picture/view.hpp"'),
    ("client/app/report/bad.cpp", "#include <boost/asio.hpp>"),
    ("client/cli/live/bad.cpp", '#include "client/measure/statistics.hpp"'),
    ("client/measure/bench/bad.cpp", '#include "client/cli/recording/reader.hpp"'),
    ("client/cli/manual/bad.cpp", '#include "client/app/options/values.hpp"'),
    ("client/cli/manual/bad.cpp", "#include <CLI/CLI.hpp>"),
    ("client/measure/bench/bad.cpp", '#include "client/cli/commands.hpp"'),
    ("client/measure/bench/bad.cpp", '#include "client/app/options/options.hpp"'),
    ("client/app/report/bad.cpp", "#include <CLI/CLI.hpp>"),
    ("client/cli/web/bad.cpp", '#include "client/cli/commands.hpp"'),
    ("client/cli/web/bad.cpp", "#include <boost/beast/core.hpp>"),
]


class CheckLayers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for path, text in GOOD.items():
            self.write(path, text)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def test_a_clean_tree_passes(self):
        self.assertEqual(check_layers.bad_includes(self.root), [])

    def test_each_bad_include_is_found(self):
        for path, line in BAD:
            with self.subTest(path=path, line=line):
                before = (self.root / path).read_text() if (self.root / path).exists() else None
                self.write(path, line + "\n")
                found = check_layers.bad_includes(self.root)
                self.assertEqual(len(found), 1, found)
                self.assertIn(f"{path}:1:", found[0])
                (self.root / path).unlink()
                if before is not None:
                    self.write(path, before)

    def test_a_folder_that_no_page_names_is_found(self):
        named = {path.rpartition("/")[0] for path in GOOD}
        pages = {layer: " ".join(f"`{folder}/`" for folder in named if folder.startswith(layer)) for layer in ("client", "gpu", "server")}
        for layer, text in pages.items():
            self.write(f"{layer}/README.md", text)
        self.write("proto/README.md", "")
        self.write("client/go/v1/message.pb.go", "")
        self.write(".gitattributes", "# Generated:\n/client/go/v1/*.pb.go linguist-generated\n")
        self.write("tests/gpu/step/list_test.cpp", "")  # mirrors gpu/step
        self.write("tests/many/results/figure.json", "")
        self.assertEqual(check_layers.nameless_folders(self.root)[0], [])
        self.write("tests/many/any_test.cpp", "")
        self.write("gpu/attic/old.hpp", "")
        says = "no README.md above it says what it is for"
        self.assertEqual(check_layers.nameless_folders(self.root)[0], [f"gpu/attic: {says}", f"tests/many: {says}"])
        self.write("tests/many/README.md", "")
        self.write("gpu/README.md", pages["gpu"] + " `attic/`")
        check_layers.page.cache_clear()
        self.assertEqual(check_layers.nameless_folders(self.root)[0], [])

    def test_a_header_that_needs_another_is_found(self):
        self.write("gpu/exec/cpu.hpp", "#include <cstddef>\n")
        (self.root / "client/cpp/client.hpp").unlink()  # needs generated code
        self.assertEqual(check_layers.bad_headers(self.root, "c++", [])[0], [])
        self.write("gpu/base/lonely.hpp", "#pragma once\ninline std::vector<int> f() { return {}; }\n")
        errors, count = check_layers.bad_headers(self.root, "c++", [])
        self.assertEqual(len(errors), 1)
        self.assertIn("lonely.hpp", "".join(errors))
        # A source may have precompiled headers, and proves nothing; a header that includes it first is compiled with it.
        self.write("gpu/base/lonely.cpp", '#include "gpu/base/lonely.hpp"\n')
        self.assertEqual(check_layers.bad_headers(self.root, "c++", [])[1], count)
        self.write("gpu/base/above.hpp", '#pragma once\n#include "gpu/base/lonely.hpp"\n')
        errors, again = check_layers.bad_headers(self.root, "c++", [])
        self.assertEqual((len(errors), again), (1, count))
        self.assertIn("lonely.hpp", errors[0])

    def with_a_large_header(self):
        """Makes `large.hpp`, which is precompiled because five headers include it."""
        self.root = self.root / "other"
        self.write("gpu/base/large.hpp", f"#pragma once\n#include <vector>\n// {'a' * check_layers.WRITING}\n")
        for name in ("a", "b", "c", "d", "e"):
            self.write(f"gpu/base/{name}.hpp", '#pragma once\n#include <cstddef>\n#include "gpu/base/large.hpp"\n'
                       f"inline std::vector<int> {name}() {{ return {{}}; }}\n")
        headers = check_layers.Headers(self.root)
        self.assertEqual({header.stem: base for header, base in headers.bases().items()},
                         {name: "gpu/base/large.hpp" for name in ("a", "b", "c", "d", "e")})

    def test_what_others_are_compiled_on_top_of_hides_nothing(self):
        self.with_a_large_header()
        self.assertEqual(check_layers.bad_headers(self.root, "c++", []), ([], 6))
        for includes in ("", '#include <cstddef>\n#ifdef NEVER\n#include "gpu/base/large.hpp"\n#endif\n'):
            self.write("gpu/base/lonely.hpp", f"#pragma once\n{includes}inline std::vector<int> f() {{ return {{}}; }}\n")
            errors, count = check_layers.bad_headers(self.root, "c++", [])
            self.assertEqual((len(errors), count), (1, 7))
            self.assertIn("lonely.hpp", errors[0])

    def test_what_others_are_compiled_on_top_of_is_compiled_alone_itself(self):
        self.with_a_large_header()
        self.write("gpu/base/large.hpp", (self.root / "gpu/base/large.hpp").read_text().replace("#include <vector>", "inline std::vector<int> f();"))
        errors, _ = check_layers.bad_headers(self.root, "c++", [])
        self.assertIn("gpu/base/large.hpp:2", errors[0])


if __name__ == "__main__":
    unittest.main()

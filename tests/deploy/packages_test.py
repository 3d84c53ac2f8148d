#!/usr/bin/env python3
"""The Debian packages of a build: made by cpack, accepted by lintian, with what they should have.

usage: packages_test.py CPACK REPOSITORY BUILD VERSION PACKAGES    (PACKAGES: the folder that they are left in)
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

CPACK = sys.argv[1]
REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:4])
VERSION = sys.argv[4] + "-1"
PACKAGES = pathlib.Path(sys.argv[5]).resolve()


def run(*command, folder=None):
    done = subprocess.run([str(word) for word in command], text=True, cwd=folder, timeout=900, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, f"{command}\n{done.stdout}"
    return done.stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(PACKAGES, ignore_errors=True)
        # Fast compression: these are not for anybody's disk.
        run(CPACK, "-B", PACKAGES, "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip", folder=BUILD)
        shutil.rmtree(PACKAGES / "_CPack_Packages", ignore_errors=True)
        cls.packages = {path.name.split("_")[0]: path for path in PACKAGES.glob("*.deb")}

    def field(self, package, name):
        return run("dpkg-deb", "-f", self.packages[package], name).strip()

    def paths(self, package):
        return {line.split()[5].removeprefix(".") for line in run("dpkg-deb", "-c", self.packages[package]).splitlines()}

    def daemon(self):
        return next(name for name in self.packages if name in ("collided", "collided-cuda"))

    def test_there_is_one_for_each_part(self):
        self.assertEqual(set(self.packages), {self.daemon(), "libcollided1", "libcollided-dev", "python3-collided"})
        self.assertEqual({self.field(name, "Version") for name in self.packages}, {VERSION})

    def test_the_daemons_has_programs_pages_completions_configuration_and_units(self):
        self.assertLessEqual(
            {"/usr/bin/collided", "/usr/bin/collidectl", "/usr/share/man/man8/collided.8.gz",
             "/usr/share/man/man1/collidectl-stream.1.gz", "/usr/share/man/man5/collided.toml.5.gz",
             "/usr/share/bash-completion/completions/collidectl", "/usr/share/zsh/vendor-completions/_collidectl",
             "/usr/share/fish/vendor_completions.d/collidectl.fish", "/etc/collided/collided.toml",
             "/usr/lib/systemd/system/collided.service", "/usr/lib/sysusers.d/collided.conf",
             "/usr/share/collided/entrance/entrance", "/usr/share/collided/entrance/haproxy.cfg.in",
             "/usr/share/collided/entrance/free_memory.lua"}, self.paths(self.daemon()))

    def test_only_a_build_with_cuda_has_units_for_gpus(self):
        units = {"/usr/lib/systemd/system/collided@.service", "/usr/lib/systemd/system/collided-nvidia.service"}
        self.assertEqual(units & self.paths(self.daemon()), units if self.daemon() == "collided-cuda" else set())

    def test_dependencies_come_from_what_the_programs_are_linked_with(self):
        depends = self.field(self.daemon(), "Depends")
        for library in ("libgrpc++1.51", "libprotobuf32", "libtbb12", "libgmp10"):
            self.assertIn(library, depends)
        self.assertNotIn("-dev", depends)
        self.assertNotIn("cuda", depends)  # the driver is found when the daemon starts, or is not there

    def test_the_two_daemons_replace_each_other(self):
        other = {"collided": "collided-cuda", "collided-cuda": "collided"}[self.daemon()]
        for name in ("Conflicts", "Replaces"):
            self.assertEqual(self.field(self.daemon(), name), other)
        provided = f"collided (= {VERSION})" if self.daemon() == "collided-cuda" else ""
        self.assertEqual(self.field(self.daemon(), "Provides"), provided)

    def test_the_development_package_has_headers_libraries_and_the_cmake_package(self):
        names = {pathlib.PurePath(path).name for path in self.paths("libcollided-dev")}
        self.assertLessEqual({"session.hpp", "local.hpp", "scene.pb.h", "libcollided_client.a", "libcollided_local.a",
                              "collidedConfig.cmake", "collided.h", "libcollided.so", "collided.pc", "collided-c.pc"}, names)
        self.assertIn(f"libcollided1 (= {VERSION})", self.field("libcollided-dev", "Depends"))

    def test_the_librarys_package_has_it_alone_and_needs_nothing_of_the_daemons(self):
        names = {path for path in self.paths("libcollided1") if path.startswith("/usr/lib/lib")}
        self.assertEqual({name.partition(".so")[0] for name in names}, {"/usr/lib/libcollided"})
        self.assertIn("/usr/lib/libcollided.so.1", names)
        depends = self.field("libcollided1", "Depends")
        self.assertIn("libtbb12", depends)
        self.assertNotRegex(depends, "grpc|protobuf|ssl")

    def test_the_python_package_has_modules_messages_types_and_its_version(self):
        modules = "/usr/lib/python3/dist-packages/"
        paths = self.paths("python3-collided")
        self.assertLessEqual({f"{modules}collided/{name}" for name in ("__init__.py", "py.typed", "v1/scene_pb2.py")}, paths)
        self.assertTrue([path for path in paths if path.endswith("egg-info/PKG-INFO")], paths)

    def test_the_sbom_has_every_package_that_the_daemons_depends_on(self):
        document = json.loads(run(REPOSITORY / "deploy" / "sbom", BUILD))
        packages = {package["SPDXID"]: package for package in document["packages"]}
        self.assertEqual(len(packages), len(document["packages"]))
        names = {package["name"]: package["versionInfo"] for package in packages.values()}
        self.assertEqual(names["collided"], VERSION.removesuffix("-1"))
        self.assertEqual("CUDA Runtime" in names, self.daemon() == "collided-cuda")
        libraries = set(re.findall(r"(lib[\w.+-]+)", self.field(self.daemon(), "Depends")))
        # A virtual package has another name here: the one that provides it.
        (virtual,) = (name for name in libraries if name not in names)
        self.assertRegex(virtual, r"^libspdlog[\d.]+-fmt\d+$")
        grpc = next(name for name in libraries if re.match(r"libgrpc\d", name))
        self.assertEqual(names[grpc], run("dpkg-query", "-W", "-f", "${Version}", grpc))
        for relation in document["relationships"]:
            for end in ("spdxElementId", "relatedSpdxElement"):
                self.assertIn(relation[end], {*packages, "SPDXRef-DOCUMENT"})

    def test_lintian_finds_nothing(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed")
        run("lintian", "--allow-root", "--fail-on", "error,warning", *self.packages.values())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

"""Arguments and environment, without a server."""

import os
import pathlib
import socket
import tempfile
import unittest
from typing import Dict, Optional
from unittest import mock

from counterpoint import Client, Unreachable
from counterpoint.files import Pack
from counterpoint.settings import Settings, resolve
from counterpoint.words import milliseconds, priority, states


def settings(address: Optional[str] = None, token: Optional[str] = None, **given: str) -> Settings:
    files = [given.get(name) for name in ("ca", "certificate", "key")]
    return resolve(address, token, files[0], files[1], files[2], None)


class Environment(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment({})

    def environment(self, variables: Dict[str, str]) -> None:
        patch = mock.patch.dict(os.environ, variables, clear=True)
        patch.start()
        self.addCleanup(patch.stop)

    def test_the_address_comes_from_the_argument_then_the_environment(self) -> None:
        self.assertEqual(settings().url, "http://127.0.0.1:7878")
        self.environment({"COUNTERPOINT_SERVER": "http://cell-1.example:7000"})
        self.assertEqual(settings().url, "http://cell-1.example:7000")
        self.assertEqual(settings("http://[::1]:7001/").target, "[::1]:7001")
        self.assertEqual(settings("https://cell-2.example").target, "cell-2.example:443")

    def test_an_address_that_cannot_be_used_names_the_forms(self) -> None:
        for wrong in ["cell-1", "cell-1:x", "ftp://cell-1:21", "http://", "http://cell-1:1/path"]:
            with self.assertRaisesRegex(ValueError, "expected HOST:PORT, http://HOST:PORT or https://HOST:PORT"):
                settings(wrong)

    def test_the_token_is_sent_and_never_shown(self) -> None:
        self.environment({"COUNTERPOINT_TOKEN": " cpt_env\n"})
        self.assertEqual(settings().metadata, (("authorization", "Bearer cpt_env"),))
        self.assertEqual(settings(token="cpt_own").metadata, (("authorization", "Bearer cpt_own"),))
        self.assertEqual(settings(token="").metadata, (), "an empty token is no token")
        self.assertNotIn("cpt_", repr(settings()))
        for wrong in ["cpt_a\nb", "cpt_ä"]:
            with self.assertRaises(ValueError) as raised:
                settings(token=wrong)
            self.assertNotIn("cpt_", str(raised.exception))

    def test_certificates_mean_tls(self) -> None:
        self.environment({"COUNTERPOINT_CA": "no-such.pem"})
        with self.assertRaisesRegex(OSError, "COUNTERPOINT_CA: 'no-such.pem' does not exist"):
            settings("cell-1:7878")
        self.environment({"COUNTERPOINT_CLIENT_CERT": "no-such.pem"})
        with self.assertRaisesRegex(ValueError, r"without key \(COUNTERPOINT_CLIENT_KEY\)"):
            settings("cell-1:7878")
        self.assertIsNone(settings("http://cell-1:7878").credentials, "the scheme decides")
        self.environment({"COUNTERPOINT_CA": ""})
        self.assertIsNone(settings("cell-1:7878").credentials, "an empty variable is no variable")
        with self.assertRaisesRegex(ValueError, "certificates need TLS: give https:// "):
            settings("http://cell-1:7878", ca="ca.pem")

    def test_a_file_that_is_no_certificate_is_named(self) -> None:
        file = self.folder / "ca.pem"
        file.write_text("not a certificate")
        with self.assertRaisesRegex(ValueError, "ca: '.*ca.pem' is not a file of certificates"):
            settings("https://cell-1:7878", ca=str(file))

    def test_a_certificate_needs_its_key(self) -> None:
        with self.assertRaisesRegex(ValueError, r"certificate is given without key \(COUNTERPOINT_CLIENT_KEY\)"):
            settings("https://cell-1:7878", certificate="own.pem")
        self.environment({"COUNTERPOINT_CLIENT_KEY": "own.key"})
        with self.assertRaisesRegex(ValueError, r"COUNTERPOINT_CLIENT_KEY is given without certificate"):
            settings("https://cell-1:7878")

    def test_a_closed_port_is_reported_with_its_cause(self) -> None:
        with socket.socket() as closed:
            closed.bind(("127.0.0.1", 0))
            address = f"127.0.0.1:{closed.getsockname()[1]}"
            with self.assertRaisesRegex(Unreachable, f"no server answers at http://{address} .*refused.*check the addr"):
                Client(address, reach=0.2)

    def test_a_folder_adds_its_files_and_a_name_has_one_content(self) -> None:
        (self.folder / "deeper").mkdir()
        (self.folder / "O2.nc").write_bytes(b"O2\nM99\n")
        (self.folder / "O3.nc").write_bytes(b"O3\nM99\n")
        pack = Pack()
        self.assertEqual(pack.programs({"a.nc": b"O1\nM98 P2\nM30\n"}), ["a.nc"])
        pack.others([self.folder])
        self.assertEqual(list(pack.digests), ["a.nc", "O2.nc", "O3.nc"])
        with self.assertRaisesRegex(ValueError, "two files are named O2.nc and differ"):
            pack.others({"O2.nc": b"O2\nM30\n"})
        with self.assertRaisesRegex(TypeError, "give a list of paths"):
            pack.programs("a.nc")

    def test_a_word_that_is_unknown_names_the_words(self) -> None:
        with self.assertRaisesRegex(ValueError, "'urgent' is not a priority: expected low, normal, high"):
            priority("urgent")
        with self.assertRaisesRegex(ValueError, "'done' is not a state: expected queued, running, succeeded"):
            states(["done"])
        self.assertEqual(milliseconds(None), 0)


if __name__ == "__main__":
    unittest.main()

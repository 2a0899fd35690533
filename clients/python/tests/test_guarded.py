"""Against the server with TLS and identities at COUNTERPOINT_TEST_TLS_SERVER, whose queue has one place.

COUNTERPOINT_TEST_MUTUAL_SERVER also requires certificates of clients. COUNTERPOINT_TEST_FOLDER has ca.pem, other.pem
(an authority that has not signed the servers), client.pem, client.key, and token.
"""

import os
import pathlib
import unittest
from unittest import mock

from counterpoint import Client, Refused, Unreachable

ADDRESS = os.environ.get("COUNTERPOINT_TEST_TLS_SERVER", "")
MUTUAL = os.environ.get("COUNTERPOINT_TEST_MUTUAL_SERVER", "")
PLAIN = os.environ.get("COUNTERPOINT_TEST_SERVER", "")
FOLDER = pathlib.Path(os.environ.get("COUNTERPOINT_TEST_FOLDER", ""))
CA = FOLDER / "ca.pem"
ENDLESS = b"O1\nG1 X1. F100\nN1 G4 P9\nGOTO 1\nM30\n"


class Guarded(unittest.TestCase):
    def setUp(self) -> None:
        patch = mock.patch.dict(os.environ, clear=True)
        patch.start()
        self.addCleanup(patch.stop)
        self.token = (FOLDER / "token").read_text()

    def test_token_and_authorities_come_from_arguments(self) -> None:
        for address in [ADDRESS, f"https://{ADDRESS}"]:
            with Client(address, token=self.token, ca=CA) as client:
                self.assertIn("fanuc-mill", client.machines())

    def test_token_and_authorities_come_from_the_environment(self) -> None:
        os.environ["COUNTERPOINT_SERVER"] = f"https://{ADDRESS}"
        os.environ["COUNTERPOINT_TOKEN"] = self.token
        os.environ["COUNTERPOINT_CA"] = str(CA)
        with Client() as client:
            self.assertIn("fanuc-mill", client.machines())

    def test_a_certificate_of_another_authority_is_said(self) -> None:
        with self.assertRaisesRegex(Unreachable, "the certificate of the server at .* is not accepted .*issuer"):
            Client(ADDRESS, token=self.token, ca=FOLDER / "other.pem", reach=0.5)

    def test_a_certificate_for_another_name_is_said(self) -> None:
        address = ADDRESS.replace("localhost", "127.0.0.1")
        with self.assertRaisesRegex(Unreachable, "is not accepted .*not valid for '127.0.0.1'"):
            Client(address, token=self.token, ca=CA, reach=0.5)

    def test_an_address_with_the_wrong_scheme_is_said(self) -> None:
        with self.assertRaisesRegex(Unreachable, "expects TLS: give https://"):
            Client(f"http://{ADDRESS}", token=self.token, reach=0.5)
        with self.assertRaisesRegex(Unreachable, "answers without TLS: give http://"):
            Client(f"https://{PLAIN}", token=self.token, ca=CA, reach=0.5)

    def test_a_server_that_requires_a_certificate_gets_it_or_says_so(self) -> None:
        own, key = FOLDER / "client.pem", FOLDER / "client.key"
        with Client(MUTUAL, token=self.token, ca=CA, certificate=own, key=key) as client:
            self.assertIn("fanuc-mill", client.machines())
        with self.assertRaisesRegex(Unreachable, "requires a certificate of the client: give certificate and key"):
            Client(MUTUAL, token=self.token, ca=CA, reach=0.5)
        os.environ["COUNTERPOINT_CLIENT_CERT"], os.environ["COUNTERPOINT_CLIENT_KEY"] = str(own), str(key)
        with Client(MUTUAL, token=self.token, ca=CA) as client:
            self.assertIn("fanuc-mill", client.machines())
        with self.assertRaisesRegex(ValueError, "COUNTERPOINT_CLIENT_KEY: .*are not a certificate and its key"):
            Client(MUTUAL, token=self.token, ca=CA, certificate=CA)

    def test_a_call_without_a_known_token_is_refused(self) -> None:
        with Client(ADDRESS, ca=CA) as client, self.assertRaises(Refused) as raised:
            client.machines()
        self.assertEqual(raised.exception.reason, "UNAUTHENTICATED")
        self.assertIn("give token or set COUNTERPOINT_TOKEN", raised.exception.message)
        with Client(ADDRESS, ca=CA, token="cpt_00") as client, self.assertRaises(Refused) as raised:
            client.machines()
        self.assertNotIn("COUNTERPOINT_TOKEN", raised.exception.message)

    def test_a_full_queue_is_a_refusal_with_a_time_to_wait(self) -> None:
        with Client(ADDRESS, token=self.token, ca=CA) as client:
            jobs = []
            try:
                with self.assertRaises(Refused) as raised:
                    for _ in range(20):
                        jobs.append(client.submit("fanuc-mill", {"a.nc": ENDLESS}))
            finally:
                for job in jobs:
                    client.cancel(job)
        self.assertEqual((raised.exception.reason, raised.exception.code.name), ("QUEUE_FULL", "RESOURCE_EXHAUSTED"))
        self.assertIsNotNone(raised.exception.retry_after)


if __name__ == "__main__":
    unittest.main()

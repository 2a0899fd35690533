//! The channel to a server, with the token of the caller.

use tonic::service::interceptor::InterceptedService;
use tonic::transport::Channel;

use crate::MAX_MESSAGE;
use crate::error::Error;
use crate::reach::{AddressedChannel, cause};
use crate::settings::{CallMetadata, ClientSettings};
use crate::v1::admin_client::AdminClient;
use crate::v1::blobs_client::BlobsClient;
use crate::v1::jobs_client::JobsClient;
use crate::v1::machines_client::MachinesClient;
use crate::v1::operator_client::OperatorClient;
use crate::v1::results_client::ResultsClient;

/// A connection that adds the token of the caller to each call.
pub type Through = InterceptedService<AddressedChannel, CallMetadata>;

/// A channel; a lost one is made again with the next call.
#[derive(Debug, Clone)]
pub(crate) struct Connection {
    channel: Through,
    pub(crate) settings: ClientSettings,
}

impl Connection {
    pub(crate) async fn open(settings: &ClientSettings) -> Result<Self, Error> {
        let unreachable = |error| Error::Unreachable { address: settings.address().to_owned(), cause: cause(&error) };
        let channel = settings.endpoint()?.connect().await.map_err(unreachable)?;
        Ok(Self::over(channel, settings))
    }

    /// Over a channel that exists.
    pub(crate) fn over(channel: Channel, settings: &ClientSettings) -> Self {
        let reach = AddressedChannel::new(channel, settings.address());
        Self { channel: InterceptedService::new(reach, settings.call()), settings: settings.clone() }
    }

    pub(crate) fn jobs(&self) -> JobsClient<Through> {
        JobsClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE)
    }

    pub(crate) fn admin(&self) -> AdminClient<Through> {
        AdminClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE)
    }

    pub(crate) fn machines(&self) -> MachinesClient<Through> {
        MachinesClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE)
    }

    pub(crate) fn operator(&self) -> OperatorClient<Through> {
        OperatorClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE)
    }

    pub(crate) fn results(&self) -> ResultsClient<Through> {
        ResultsClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE)
    }

    pub(crate) fn blobs(&self) -> BlobsClient<Through> {
        BlobsClient::new(self.channel.clone()).max_decoding_message_size(MAX_MESSAGE)
    }
}
